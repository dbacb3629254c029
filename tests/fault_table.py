#!/usr/bin/python3
"""Writes docs/faults.md: what may go wrong, and what must happen then, from the names and words of the tests that try it.

Results come from what the tests' last runs left in target/results; a test that has not run says so.
"""

import argparse
import ast
import pathlib
import xml.etree.ElementTree

CHECKOUT = pathlib.Path(__file__).resolve().parent.parent
PAGE = CHECKOUT / 'docs' / 'faults.md'
RESULTS = CHECKOUT / 'target' / 'results'
# Title, and the tests under it. Those of tests/hosts run by `make test-hosts`, the others by `make test`.
CHAPTERS = (
    ('Callers that go away', 'tests/hosts/test_callers.py'),
    ('Nodes that are told to end', 'tests/test_ends.py'),
    ('Objects that change during a scan', 'tests/test_changed_object.py'),
    ('Between computers', 'tests/hosts/test_links.py'),
    ('Cameras, clocks, people and strangers', 'tests/hosts/test_faults.py'),
    ('The wrist', 'tests/test_wrist.py'),
    ('Nodes that are killed', 'tests/test_kills.py'),
    ('The links of one node', 'tests/test_links.py'),
)
# Columns from which on the tests' documentation is folded, and those that it is indented by.
FOLDED_FROM, INDENT = 116, 4
HEAD = '''# Faults, and what must happen

Made by `make fault-table` from the tests' own names and words; a test compares it with them. Each row is a test: the right
column is its last result when the table was made. `make test-hosts` makes a robot and three computers of this one
(namespaces, each with its own sshd, joined by a switch; needs root), starts `robot.launch` by ssh, and breaks it.
[motion.md](motion.md) says by which rule the arm stops.
'''


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(page(results()))
    print(f'written: {PAGE.relative_to(CHECKOUT)}')


def page(outcomes):
    """The whole page; `outcomes` maps (file, test) to a word."""
    lines = [HEAD]
    for title, file in CHAPTERS:
        if not (CHECKOUT / file).exists():
            continue
        about = ' '.join((ast.get_docstring(ast.parse((CHECKOUT / file).read_text())) or '').split())
        lines += [f'## {title}', '', f'[{file}](../{file}): {about}', '', '| test | what must happen | |', '|---|---|---|']
        lines += [f'| {words(name)} | {text} | {outcomes.get((module(file), name), "not run")} |'
                  for name, text in tests(CHECKOUT / file)]
        lines += ['']
    return '\n'.join(lines)


def tests(path):
    """(name, what its documentation says) of each test in the file, in its order."""
    for item in ast.parse(path.read_text()).body:
        if isinstance(item, ast.FunctionDef) and item.name.startswith('test_'):
            yield item.name, '<br>'.join(unfolded((ast.get_docstring(item) or '').strip().replace('|', '\\|')))


def module(file):
    """As pytest names it in its reports."""
    return file.removeprefix('tests/').removesuffix('.py').replace('/', '.')


def unfolded(text):
    """The text's lines, joined where the first word of the next one did not fit into the line before."""
    raw = text.splitlines()
    lines = raw[:1]
    for last, line in zip(raw, raw[1:]):
        if FOLDED_FROM < INDENT + len(last) + 1 + len(line.split(' ')[0]):
            lines[-1] += f' {line}'
        else:
            lines.append(line)
    return lines


def words(name):
    return name.removeprefix('test_').replace('_', ' ')


def results():
    """The worst outcome of each test over its parameters, by (file, test)."""
    worst = {}
    for report in RESULTS.glob('*.xml'):
        for case in xml.etree.ElementTree.parse(report).iter('testcase'):
            key = (case.get('classname').removeprefix('tests.'), case.get('name').split('[')[0])
            kinds = {child.tag for child in case}
            outcome = 'FAILED' if kinds & {'failure', 'error'} else 'skipped' if 'skipped' in kinds else 'passed'
            worst[key] = min(outcome, worst.get(key, 'passed'), key=('FAILED', 'skipped', 'passed').index)
    return worst


if __name__ == '__main__':
    main()
