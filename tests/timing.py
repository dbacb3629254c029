"""Times of a scan's stages."""

STAGES = ('capture', 'settle', 'register', 'crop', 'sample', 'infer')


def milliseconds(timing):
    """Time by stage of a scan's StageTime messages, in ms; a stage that ran for each view counts once a view."""
    spent = {}
    for entry in timing:
        spent[entry.stage] = spent.get(entry.stage, 0) + entry.elapsed.to_sec() * 1000
    return spent


def percentile(values, share):
    """The smallest of the values that at least this share of them does not exceed."""
    ordered = sorted(values)
    return ordered[max(0, -(-len(ordered) * share // 100) - 1)]
