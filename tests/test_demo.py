"""What `make demo` concludes and builds. The demo itself is a whole-system test of its own: `make demo`."""

import importlib.machinery
import importlib.util
import json
import re
import subprocess

import pytest

from graph import OBJECTS


@pytest.fixture
def conclude(checkout):
    """The demo's last words, and its exit code."""
    loader = importlib.machinery.SourceFileLoader('demo', str(checkout / 'tests' / 'demo'))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader('demo', loader))
    loader.exec_module(module)
    return module.conclude


def results(**changes):
    """All eight right and known, but for the changed: results(tiny_ball=('small-ball', True))."""
    return [(name, *changes.get(name.replace('-', '_'), (name, True))) for name in OBJECTS]


@pytest.mark.parametrize('changes, code, expected', [
    ({}, 0, '8 of 8 named rightly'),
    ({'tiny_ball': ('tiny-ball', False)}, 0, '8 of 8 named rightly'),
    ({'tiny_ball': ('small-ball', False)}, 0, 'wrong, but not called known, as it should be: tiny-ball'),
    ({'tiny_ball': ('small-ball', True)}, 1, 'WRONG AND CALLED KNOWN: tiny-ball was called small-ball'),
    ({'tiny_ball': (None, False)}, 1, 'no answer for tiny-ball'),
    ({'tiny_ball': ('', False)}, 0, '7 of 8 named rightly'),
])
def test_a_known_wrong_answer_fails_the_demo(conclude, capsys, changes, code, expected):
    assert conclude(results(**changes)) == code
    assert expected in capsys.readouterr().out


def cargo_tree(checkout, *selection):
    """Names of the crates that these packages need, without what only tests need."""
    tree = subprocess.run(['cargo', 'tree', '--offline', '--edges=normal,build', '--prefix=none', '--format={lib}', *selection],
                          cwd=checkout, stdout=subprocess.PIPE, text=True, check=True).stdout
    return set(tree.split()) - {'(*)'}


def test_the_demo_builds_only_the_graph(checkout):
    lists = (checkout / 'ros' / 'CMakeLists.txt').read_text()
    graph = re.search(r'set\(GRAPH_EXECUTABLES(.*?)\)', lists, re.DOTALL)[1].split()
    metadata = subprocess.run(['cargo', 'metadata', '--no-deps', '--offline', '--format-version=1'], cwd=checkout,
                              stdout=subprocess.PIPE, check=True)
    owner = {target['name']: package['name'] for package in json.loads(metadata.stdout)['packages']
             for target in package['targets'] if target['kind'] == ['bin']}
    needed = cargo_tree(checkout, *(f'--package={owner[name]}' for name in graph))
    everything = cargo_tree(checkout, '--workspace')
    foreign = {'candle_core', 'candle_nn', 'tokenizers', 'plotters', 'clap', 'csv', 'training'}
    assert foreign <= everything, 'these are what the check is about'
    assert not needed & foreign
    assert len(needed) < len(everything)


@pytest.mark.built
def test_the_demo_starts_no_other_programs(shell, checkout):
    """What it builds is what sim.launch starts."""
    lists = (checkout / 'ros' / 'CMakeLists.txt').read_text()
    graph = set(re.search(r'set\(GRAPH_EXECUTABLES(.*?)\)', lists, re.DOTALL)[1].split())
    started = set()
    nodes = shell('roslaunch deformable_cobot sim.launch rviz:=true --nodes').split()
    # RViz itself need not be installed.
    for node in (node for node in nodes if node != '/rviz'):
        command = shell(f'roslaunch deformable_cobot sim.launch rviz:=true --args={node}')
        started.update(re.findall(r'/lib/deformable_cobot/(\w+)', command))
    assert started == graph
