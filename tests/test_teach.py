"""An object that nobody knew: taught while the graph runs, and named by the next scan."""

import json
import shutil
import subprocess

import pytest

from graph import Listener
from processes import wait_until
from shapes import write_obj

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

# Outline (radius, height), mm; the ends fit between the fingers.
SPOOL_MM = [(0, 0), (42, 0), (42, 20), (25, 45), (25, 75), (42, 100), (42, 120), (0, 120)]
# Few, so that it takes seconds.
FEW = ('--dents', 12, '--scans', 40)


@pytest.fixture
def spool(tmp_path):
    """Path of the object's mesh file."""
    path = tmp_path / 'spool.obj'
    write_obj(path, SPOOL_MM)
    return path


@pytest.fixture
def references(checkout, tmp_path):
    """A folder of references of one's own."""
    folder = tmp_path / 'of the graph'
    shutil.copytree(checkout / 'config' / 'references', folder)
    return folder


def hold(graph, path, squeeze_m=0.006):
    answer = graph.call('hold_object', object=str(path), squeeze=squeeze_m, seed=1)
    assert answer.success, answer.error


def test_an_unknown_object_is_taught_while_the_graph_runs(launch, core, executable, spool, references, shelf):
    from deformable_cobot.msg import Deformation
    sim = launch('sim.launch', references=references)
    sim.wait_for_service('scan_object', timeout_s=60)
    hold(sim, spool)
    before = sim.scan().result
    assert 'spool' not in before.labels and not before.known

    model = shelf / 'taught.onnx'
    printed = core.output(executable('teach'), 'spool', '--scan', spool, '--model', model, *FEW, '--load', '--json',
                          timeout_s=120)
    # What happens is said on stderr, before and after.
    taught = json.loads(printed[printed.index('{'):printed.rindex('}') + 1])
    print(json.dumps(taught))
    assert taught['held_out']['right'] > 0.8
    measured = Listener('deformation', Deformation)
    after = sim.scan()
    assert after.error == ''
    print(after.result.label, after.result.probability)
    assert (after.result.label, after.result.known) == ('spool', True)
    assert after.result.model_id != before.model_id
    compared = measured.next(30, lambda answer: answer.scan_id == after.result.scan_id and answer.complete)
    assert compared.reference == str(references / 'spool.ply')


def test_the_robot_records_what_it_is_taught(launch, core, executable, spool, references, shelf):
    sim = launch('sim.launch', references=references)
    sim.wait_for_service('scan_object', timeout_s=60)
    hold(sim, spool, squeeze_m=0.0)
    model = shelf / 'taught.onnx'
    script = f'cd {shelf} && {executable("teach")} reel --grasps 1 --model {model} ' + ' '.join(map(str, FEW))
    teaching = core.run('bash', '-c', script, stdin=subprocess.DEVNULL)
    assert teaching.wait(150) == 0, teaching.printed()
    print(teaching.printed())
    assert (shelf / 'reel.ply').is_file() and (references / 'reel.ply').is_file()
    hold(sim, spool)
    wait_until(lambda: sim.scan().result.label == 'reel', 60, 'the new model')


def test_without_a_graph_the_model_is_written_and_the_remedy_said(core, executable, spool, shelf):
    model = shelf / 'taught.onnx'
    teaching = core.run(executable('teach'), 'spool', '--scan', spool, '--model', model, '--dents', 4, '--scans', 6,
                        '--load')
    assert teaching.wait(120) == 1, teaching.printed()
    assert 'is written, but the classifier does not use it yet' in teaching.printed()
    assert f'model:={model}' in teaching.printed() and model.is_file()
