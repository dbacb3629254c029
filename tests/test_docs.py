"""README and docs: what they name exists."""

import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

import pytest

CHECKOUT = pathlib.Path(__file__).resolve().parent.parent
PAGES = sorted([CHECKOUT / 'README.md', CHECKOUT / 'CONTRIBUTING.md', *CHECKOUT.glob('docs/*.md')])
# Tools of ROS itself that begin as ours do.
FOREIGN_PACKAGES = {'dynamic_reconfigure', 'realsense2_camera', 'baxter_tools'}


def named(page):
    return str(page.relative_to(CHECKOUT))


def code(text):
    """What stands between backticks, in blocks and in lines; folded lines joined."""
    blocks = re.findall(r'^```\w*\n(.*?)^```', text, flags=re.DOTALL | re.MULTILINE)
    rest = re.sub(r'^```.*?^```', '', text, flags=re.DOTALL | re.MULTILINE)
    words = [' '.join(found.split()) for found in re.findall(r'`([^`]+)`', rest)]
    return [line for block in blocks for line in block.replace('\\\n', ' ').splitlines()] + words


ALL_CODE = [(named(page), line) for page in PAGES for line in code(page.read_text())]


def commands(pattern):
    """(page, found groups) wherever the pattern stands in code."""
    return [(page, found) for page, line in ALL_CODE for found in re.findall(pattern, line)]


def anchors(page):
    """Of a page's headings, as GitHub makes them."""
    headings = re.findall(r'^#+ (.*)$', page.read_text(), flags=re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


def test_the_first_hour_fits_into_readme():
    assert len((CHECKOUT / 'README.md').read_text().splitlines()) <= 150


@pytest.mark.parametrize('page', PAGES, ids=named)
def test_links_lead_somewhere(page):
    for target in re.findall(r'\]\(([^)]+)\)', page.read_text()):
        if target.startswith('http'):
            continue
        path, _, anchor = target.partition('#')
        there = (page.parent / path).resolve() if path else page
        assert there.exists(), f'{target} is not there'
        assert not anchor or anchor in anchors(there), f'{target}: no such heading'


def test_every_page_of_docs_is_linked_from_readme():
    readme = (CHECKOUT / 'README.md').read_text()
    assert [page.name for page in CHECKOUT.glob('docs/*.md') if f'(docs/{page.name})' not in readme] == []


def test_make_targets_exist():
    targets = set(re.findall(r'^([a-z-]+):', (CHECKOUT / 'Makefile').read_text(), flags=re.MULTILINE))
    told = commands(r'(?:^|&& |=1 )make ([a-z-]+)')
    assert len(told) > 10
    assert [(page, target) for page, target in told if target not in targets] == []


def test_programs_exist(executables):
    told = commands(r'target/release/(\w+)') + commands(r'rosrun deformable_cobot (\w+)')
    assert len(told) > 10
    assert [(page, program) for page, program in told if program not in executables] == []


def test_launch_files_and_their_arguments_exist():
    told = commands(r'([a-z_]+\.launch)((?: \w+:="?[^ ]+)*)')
    assert len(told) > 10
    for page, (file, arguments) in told:
        if any(package in line for _, line in ALL_CODE if file in line for package in FOREIGN_PACKAGES):
            continue
        path = CHECKOUT / 'launch' / file
        assert path.exists(), f'{page}: {file}'
        known = {argument.get('name') for argument in xml.etree.ElementTree.parse(path).iter('arg')}
        assert set(re.findall(r'(\w+):=', arguments)) <= known, f'{page}: {file} {arguments}'


def test_services_are_offered_by_the_graph():
    offered = set(re.findall(r'\| serves \| `/(\w+)`', (CHECKOUT / 'launch' / 'README.md').read_text()))
    told = commands(r'rosservice call /(\w+)')
    assert len(told) > 5
    assert [(page, service) for page, service in told if service not in offered] == []


def test_files_exist():
    told = commands(r'(?:^|[ "(])((?:config|launch|setup|ros|tests|docs|\.ci)/[\w./-]+)')
    assert [(page, file) for page, file in told
            if 'NODE' not in file and not (CHECKOUT / file.rstrip('.')).exists()] == []


def test_the_remedies_of_nodes_name_their_tests():
    rows = re.findall(r'^//! \| (?!what|---)(.+) \|$', (CHECKOUT / 'lib/node/src/lib.rs').read_text(), flags=re.MULTILINE)
    tests = {file.relative_to(CHECKOUT / 'tests').as_posix(): file.read_text()
             for file in (CHECKOUT / 'tests').rglob('test_*.py')}
    names = set(tests) | {name for text in tests.values() for name in re.findall(r'^def (test_\w+)', text, flags=re.MULTILINE)}
    assert len(rows) > 9
    for row in rows:
        told = re.findall(r'`([^`]+)`', row.split(' | ')[-1])
        assert told and set(told) <= names, row


@pytest.mark.built
def test_options_are_taken(executables, executable):
    told = commands(r'(?:target/release/|rosrun deformable_cobot )(\w+)((?: (?!#)[^ ]+)*)')
    for page, (program, rest) in told:
        words = [rest.split()[0]] if re.match(r' [a-z]+\b(?!/)', rest) and program == 'generate_dataset' else []
        help_text = subprocess.run([executable(program), *words, '--help'], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, timeout=20, check=False).stdout
        for option in re.findall(r'(?<= )--[a-z-]+', rest):
            assert option in help_text, f'{page}: {program} {option}'


def test_faults_are_those_of_the_tests():
    """All but the results, which are of the day the table was made; none of them is a failure."""
    sys.path.insert(0, str(CHECKOUT / 'tests'))
    import fault_table
    made = (CHECKOUT / 'docs' / 'faults.md').read_text()
    assert 'FAILED' not in made
    last_column = re.compile(r'\| (passed|skipped|not run) \|$', flags=re.MULTILINE)
    assert last_column.sub('||', made) == last_column.sub('||', fault_table.page({})), 'run: make fault-table'
