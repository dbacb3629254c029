"""Objects of one's own: recorded by the robot, dented by the hundred, learned, and known by it."""

import json
import subprocess

import pytest

from processes import wait_until
from shapes import write_obj

pytestmark = [pytest.mark.built, pytest.mark.timeout(300)]

# Outlines (radius, height), mm; both ends fit between the fingers.
OWN = {
    'carton': {'outline_mm': [(0, 0), (31, 0), (31, 115), (0, 115)], 'square': True},
    'jar': {'outline_mm': [(0, 0), (42, 0), (42, 65), (30, 82), (30, 105), (0, 105)]},
    'spool': {'outline_mm': [(0, 0), (42, 0), (42, 20), (25, 45), (25, 75), (42, 100), (42, 120), (0, 120)]},
}


@pytest.fixture
def shapes(tmp_path):
    """Paths of the objects' mesh files."""
    paths = {name: tmp_path / f'{name}.obj' for name in OWN}
    for name, path in paths.items():
        write_obj(path, **OWN[name])
    return paths


@pytest.fixture
def sim(launch):
    """The simulated robot, ready to scan."""
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    return graph


def hold(graph, path, squeeze_m=0.0, seed=1, **grip):
    answer = graph.call('hold_object', object=str(path), squeeze=squeeze_m, seed=seed, **grip)
    assert answer.success, answer.error


def described(printed):
    """The JSON object at the end of what a tool printed."""
    return json.loads(printed[printed.index('\n{') if not printed.startswith('{') else 0:])


def test_three_own_objects_are_recorded_learned_and_named(sim, core, launch, executable, shapes, shelf):
    for name, path in shapes.items():
        hold(sim, path)
        recording = core.run(executable('record_object'), name, '--save', shelf, '--json', stdin=subprocess.PIPE)
        wait_until(lambda: 'press Enter' in recording.printed() or not recording.running(), 60, 'the first grasp')
        assert recording.running(), recording.printed()
        hold(sim, path, upside_down=True, turn=0.9)
        # A grasp that fails can be tried again: on a busy machine TF may be late.
        recording.type('\n\n\n')
        assert recording.wait(90) == 0, recording.printed()
        made = described(recording.printed())
        print(json.dumps(made))
        # Both ends of the spool are alike.
        assert made['regrasp']['upside_down'] or name == 'spool'
        assert made['regrasp']['rmse_m'] < 0.0015
        width, depth, height = made['mesh']['extent_m']
        wide = 2 * max(radius for radius, _ in OWN[name]['outline_mm'])
        assert 1e3 * max(width, depth) == pytest.approx(wide, abs=4)
        assert 1e3 * height == pytest.approx(OWN[name]['outline_mm'][-1][1], abs=4)
        core.output(executable('generate_dataset'), '--scan', shelf / f'{name}.ply', '--out', shelf / name,
                    '--count', 36, '--seed', 1, timeout_s=60)
    sim.roslaunch.stop()

    model = shelf / 'own.onnx'
    datasets = [word for name in OWN for word in ('--dataset', shelf / name)]
    trained = core.output(executable('train'), *datasets, '--only-datasets', '--specimens', 60, '--strangers', 90,
                          '--epochs', 20, '--seed', 1, '--model', model, '--output', shelf / 'training', timeout_s=200)
    print(trained)

    sim = launch('sim.launch', model=model)
    sim.wait_for_service('scan_object', timeout_s=60)
    answers = []
    for name, path in shapes.items():
        for seed in (1, 2, 3):
            hold(sim, path, squeeze_m=0.006, seed=seed)
            answer = sim.scan()
            assert answer.error == ''
            found = answer.result
            print(name, found.label, found.known, found.probability, found.known_score, found.known_threshold, found.reason)
            assert sorted(found.labels) == sorted(OWN)
            answers.append((found.label == name, found.known))
    # One answer in twenty is unknown by design, since the threshold accepts 95 % of the validation clouds.
    assert sum(right for right, _ in answers) >= 8
    assert sum(right and known for right, known in answers) >= 6


def test_what_cannot_be_recorded_is_said_and_nothing_is_left(sim, core, executable, shapes, shelf):
    def refusal(*words):
        program = core.run(executable('record_object'), *words, '--save', shelf)
        assert program.wait(60) == 1, program.printed()
        return program.printed()

    (shelf / 'cup.ply').write_text('mine')
    assert 'cup.ply exists already; give another name, or --force' in refusal('cup')
    assert 'cannot name an object' in refusal('my cup')
    hold(sim, '')
    assert 'the hand is empty' in refusal('nothing', '--grasps', 1, '--views', 2)
    hold(sim, shapes['jar'])
    assert 'take more --views' in refusal('jar', '--grasps', 1, '--views', 2)
    assert 'nobody can press Enter here' in refusal('jar')
    assert [path.name for path in shelf.iterdir()] == ['cup.ply']
    assert (shelf / 'cup.ply').read_text() == 'mine'
