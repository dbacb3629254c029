"""Another model while the graph runs: from the next scan on, or not at all."""

import json
import threading

import pytest

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]


@pytest.fixture
def failing_model(checkout, other_model, tmp_path):
    """Writes that model with a self-test of other labels: its path."""
    path, _, after = other_model
    copy = tmp_path / 'failing.onnx'
    copy.write_bytes(path.read_bytes())
    test = json.loads((checkout / 'config' / 'model.selftest.json').read_text())
    for cloud in test['clouds']:
        cloud['label'] = 'teapot'
    test['model_id'] = after
    copy.with_suffix('.selftest.json').write_text(json.dumps(test))
    return copy


@pytest.fixture
def other_model(checkout, tmp_path):
    """Writes the shipped model under another run's name: (path, the name of before, the new name)."""
    from onnx_bytes import renamed
    path = tmp_path / 'other model.onnx'
    content, before, after = renamed((checkout / 'config' / 'model.onnx').read_bytes())
    path.write_bytes(content)
    return path, before, after


def test_a_model_is_exchanged_between_two_scans(launch, other_model, failing_model, tmp_path):
    from deformable_cobot.msg import Classification
    path, before, after = other_model
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.hold('medium-can')
    answers, responses = Listener('classification', Classification), []

    bad = tmp_path / 'bad.onnx'
    bad.write_bytes(b'no model')
    for file, words in ((bad, str(bad)), (failing_model, 'a teapot, for'),
                        (tmp_path / 'absent.onnx', 'cannot read model'), ('', 'cannot read model')):
        refused = graph.call('load_model', model=str(file))
        assert words in refused.error and refused.model_id == before, refused

    scan = threading.Thread(target=lambda: responses.append(graph.scan(4)))
    scan.start()
    assert answers.next(30).model_id == before
    loaded = graph.call('load_model', model=str(path))
    assert (loaded.error, loaded.model_id) == ('', after) and 'medium-can' in loaded.labels
    scan.join(60)
    assert (responses[0].error, responses[0].result.view_count, responses[0].result.model_id) == ('', 4, before)
    assert graph.scan(2).result.model_id == after

    killed = graph.core.kill('classifier')
    wait_until(lambda: graph.core.process_of('classifier') not in (None, killed), 20, 'roslaunch starting it again')
    wait_until(lambda: graph.scan(2).result.model_id == after, 60, 'the new model after a restart', period_s=0.5)
