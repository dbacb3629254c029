"""The ROS package as its users meet it: found, listed, shown and installed by ROS's own tools."""

import json
import os
import re
import subprocess

import pytest

from processes import wait_until

# The sums of Rethink's own package (firmware 1.2.0), and below of the ReFlex hand's.
BAXTER_SUMS = {
    'AssemblyState': '356d9dd237ce73b2667da9235f541933',
    'CollisionAvoidanceState': '30f5cb8ae019f1ffe8b599e6d2e589c7',
    'CollisionDetectionState': '7bde38c182b4d08fdc0635b116f65d04',
    'DigitalIOState': '29d0be3859dae81a66b28f167ecec98c',
    'EndEffectorCommand': 'c003234e90416f2ca02ac7837c42cbb7',
    'EndEffectorProperties': '21b83773ab9a35216d11e427573c76cc',
    'EndEffectorState': 'ade777f069d738595bc19e246b8ec7a0',
    'EndpointState': '44bea01d596ff699fa1447bec34167ac',
    'HeadPanCommand': '23b8a3f4b7ee9de7099d029e57660a8c',
    'HeadState': '71c43b264307205358e7e49be5601348',
    'JointCommand': '19bfec8434dd568ab3c633d187c36f2e',
}

REFLEX_SUMS = {
    'Finger': 'b5232f74e901b48063f64cfc32aefbe0',
    'Hand': '5328a4ca4ff4a136db2555c3178a3e1b',
    'Motor': '66d6779b4fae4b7b68e0863263c3993c',
    'PoseCommand': 'ec8e01f7c46594906539a78e3918a7c2',
}

# Presses TAB behind the words: complete FUNCTION WORD...
COMPLETE = '''
source "$(ls /usr/share/bash-completion/completions/rosrun /opt/ros/noetic/share/rosbash/rosbash 2>/dev/null | head -1)"
complete_words() {
    local function=$1; shift
    COMP_WORDS=("$@" ""); COMP_CWORD=$#; COMPREPLY=()
    $function
    printf '%s\\n' "${COMPREPLY[@]}"
}
'''

LAUNCH_FILES = {
    'sim.launch': '',
    'recorded.launch': 'captures:=.',
    'replay.launch': 'bag:=/dev/null',
    'graph.launch': '',
    'main.launch': '',
    'robot.launch': 'arm:=10.0.0.2 gripper:=10.0.0.3',
}
# Not the whole graph.
SMALL_LAUNCH_FILES = ('arm.launch', 'gripper.launch', 'sim_camera.launch', 'sim_robot.launch')


def test_manifest_is_valid(checkout):
    from catkin_pkg.package import parse_package
    warnings = []
    package = parse_package(str(checkout / 'ros'), warnings=warnings)
    assert (package.name, package.licenses, warnings) == ('deformable_cobot', ['MIT', 'Apache-2.0'], [])


def test_every_program_of_the_workspace_is_offered(checkout, executables):
    metadata = subprocess.run(['cargo', 'metadata', '--no-deps', '--offline', '--format-version=1'], cwd=checkout,
                              stdout=subprocess.PIPE, check=True)
    made = [target['name'] for package in json.loads(metadata.stdout)['packages']
            for target in package['targets'] if target['kind'] == ['bin']]
    assert sorted(made) == executables


@pytest.mark.built
def test_completion_lists_each_program_once(shell, executables):
    listed = shell(COMPLETE + 'complete_words _roscomplete_exe rosrun deformable_cobot').split()
    assert sorted(listed) == executables


@pytest.mark.built
def test_completion_lists_launch_files(shell):
    listed = shell(COMPLETE + 'complete_words _roscomplete_launch roslaunch deformable_cobot').split()
    assert {*LAUNCH_FILES, *SMALL_LAUNCH_FILES} <= set(listed)


@pytest.mark.built
def test_rosrun_finds_one_program_though_cargo_has_copies(shell):
    printed = shell('rosrun deformable_cobot classify_files --help')
    assert 'non-unique' not in printed
    assert '--json' in printed


@pytest.mark.built
def test_messages_are_shown(shell, checkout):
    for file in sorted((checkout / 'msg' / 'deformable_cobot').glob('*/*')):
        tool = {'.msg': 'rosmsg', '.srv': 'rossrv', '.action': 'rosmsg'}[file.suffix]
        kind = f'{file.stem}Action' if file.suffix == '.action' else file.stem
        fields = re.findall(r'^ *[\w/\[\]]+ +(\w+)', file.read_text(), flags=re.MULTILINE)
        shown = shell(f'{tool} show deformable_cobot/{kind}')
        assert all(field in shown for field in fields), shown


@pytest.mark.built
@pytest.mark.parametrize('package, expected', [('baxter_core_msgs', BAXTER_SUMS), ('reflex_msgs', REFLEX_SUMS)])
def test_messages_of_the_hardware_are_known_to_python_with_its_sums(checkout, package, expected):
    import roslib.message
    sums = {file.stem: roslib.message.get_message_class(f'{package}/{file.stem}')._md5sum
            for file in (checkout / 'msg' / package / 'msg').glob('*.msg')}
    assert sums == expected


@pytest.mark.built
@pytest.mark.parametrize('file', sorted(LAUNCH_FILES))
def test_launch_file_names_existing_programs_and_files(shell, file):
    nodes = shell(f'roslaunch deformable_cobot {file} {LAUNCH_FILES[file]} --nodes').split()
    assert '/classifier' in nodes
    assert len(set(nodes)) == len(nodes)
    for node in nodes:
        shell(f'roslaunch deformable_cobot {file} {LAUNCH_FILES[file]} --args={node}')


@pytest.mark.built
@pytest.mark.parametrize('file', sorted(LAUNCH_FILES))
def test_every_launch_file_shows_itself_in_rviz_on_request(shell, file):
    command = f'roslaunch deformable_cobot {file} {LAUNCH_FILES[file]} --nodes'
    with_rviz = set(shell(f'{command} rviz:=true').split()) - set(shell(command).split())
    assert {'/rviz', '/scan_markers'} <= with_rviz


@pytest.mark.built
def test_launch_files_explain_their_arguments(shell):
    for file in (*LAUNCH_FILES, *SMALL_LAUNCH_FILES):
        printed = shell(f'roslaunch deformable_cobot {file} --ros-args')
        undocumented = re.findall(r'^  \w+(?: \(default ".*"\))?$', printed, flags=re.MULTILINE)
        assert undocumented == [], printed


@pytest.mark.built
def test_a_node_goes_on_where_nobody_reads_what_it_prints(core, checkout, executable):
    """As in `roslaunch … 2>&1 | head -1`: the classifier says which model it knows before it offers its service."""
    read, write = os.pipe()
    os.close(read)
    node = subprocess.Popen([executable('classifier'), f'_model:={checkout}/config/model.onnx'],
                            env=core.environment, stdin=subprocess.DEVNULL, stdout=write, stderr=write, start_new_session=True)
    os.close(write)
    try:
        import rosservice
        wait_until(lambda: node.poll() is not None or '/classify_cloud' in rosservice.get_service_list(), 30, 'its service')
        assert node.poll() is None, f'it ended with {node.returncode}'
    finally:
        node.kill()
        node.wait()
