"""Paths in arguments of launch files, as people type them: from where they stand, from home, with spaces."""

import subprocess

import pytest
import yaml

pytestmark = [pytest.mark.built, pytest.mark.timeout(120)]


@pytest.fixture
def stand(tmp_path):
    """A folder with one of everything, where the user stands; it is home too."""
    for name in ('scan.bag', 'my scan.bag', 'own.onnx'):
        (tmp_path / name).touch()
    for name in ('captures', 'two words', 'tuned'):
        (tmp_path / name).mkdir()
    return tmp_path


@pytest.fixture
def roslaunch(core, stand):
    """Runs roslaunch from there: roslaunch('--args', 'player', 'replay.launch') -> (exit code, what it printed)."""
    def run(*words):
        at = next(at for at, word in enumerate(words) if word.endswith('.launch'))
        command = ['roslaunch', *words[:at], 'deformable_cobot', *words[at:]]
        done = subprocess.run(command, cwd=stand, env={**core.environment, 'HOME': str(stand), 'PWD': str(stand)}, text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)
        return done.returncode, done.stdout
    return run


@pytest.mark.parametrize('typed, meant', [('scan.bag', 'scan.bag'), ('./scan.bag', 'scan.bag'), ('~/scan.bag', 'scan.bag'),
                                          ('my scan.bag', 'my scan.bag'), ('{}/scan.bag', 'scan.bag')])
def test_a_bag_is_found_from_where_the_user_stands(roslaunch, stand, typed, meant):
    typed = typed.format(stand)
    played = roslaunch('--args', 'player', 'replay.launch', f'bag:={typed}')[1].replace('/./', '/')
    assert f'{stand}/{meant} --quiet' in played
    assert '/image_rect_raw/compressedDepth' in played, 'depth is recorded packed more often than not'
    # YAML may fold a long path at a space.
    parameters = ' '.join(roslaunch('--dump-params', 'replay.launch', f'bag:={typed}')[1].split())
    assert f'/player_bag: {stand}/{meant} ' in parameters


@pytest.mark.parametrize('file, argument, parameter, meant', [
    ('recorded.launch', 'captures:=captures', '/sim_camera/captures', 'captures'),
    ('recorded.launch', 'captures:=~/two words', '/sim_camera/captures', 'two words'),
    ('sim.launch', 'model:=own.onnx', '/classifier/model', 'own.onnx'),
    ('sim.launch', 'model:=~/own.onnx', '/classifier/model', 'own.onnx'),
])
def test_a_folder_or_model_is_found_from_where_the_user_stands(roslaunch, stand, file, argument, parameter, meant):
    parameters = yaml.safe_load(roslaunch('--dump-params', file, argument)[1])
    assert parameters[parameter] == str(stand / meant)


def test_tuned_values_are_found_from_where_the_user_stands(roslaunch, stand):
    loaded = roslaunch('--args', 'tune_roi_crop', 'sim.launch', 'tuned:=tuned')[1]
    assert f'load roi_crop {stand}/tuned/roi_crop.yaml' in loaded


@pytest.mark.parametrize('file, argument', [('replay.launch', 'bag:=no.bag'), ('recorded.launch', 'captures:=no such folder'),
                                            ('sim.launch', 'model:=~/no.onnx')])
def test_what_is_not_there_ends_the_launch_with_the_remedy(roslaunch, file, argument):
    code, said = roslaunch(file, argument)
    assert code != 0
    assert f'{argument}: there is no such file or folder' in said and 'absolute path' in said


def test_a_model_on_another_computer_is_the_business_of_its_classifier(roslaunch):
    _, parameters = roslaunch('--dump-params', 'robot.launch', 'arm:=10.0.0.1', 'gripper:=10.0.0.2', 'main:=10.0.0.3',
                              'model:=/there/own.onnx')
    assert '/classifier/model: /there/own.onnx\n' in parameters
