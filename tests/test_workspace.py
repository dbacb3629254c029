"""The package built by catkin in other folders and under other Pythons than those of `make build`."""

import os

import pytest

PYTHON_OF_ANOTHER = '''#!/bin/sh
echo "this Python has no ROS" >&2
exit 1
'''


@pytest.mark.built
@pytest.mark.timeout(600)
def test_installs_from_a_folder_of_another_name(shell, checkout, executables, tmp_path):
    (tmp_path / 'src').mkdir()
    (tmp_path / 'src' / 'another_name').symlink_to(checkout)
    # By its default catkin_make starts one job at a time where the machine has other work.
    shell('catkin_make install -DPYTHON_EXECUTABLE=/usr/bin/python3', timeout_s=500, ROS_PARALLEL_JOBS='-j2')

    in_installed = f'source {tmp_path}/install/setup.bash && cd / && '
    assert shell(in_installed + 'rospack find deformable_cobot').strip() == f'{tmp_path}/install/share/deformable_cobot'
    assert sorted(path.name for path in (tmp_path / 'install' / 'lib' / 'deformable_cobot').iterdir()
                  if path.is_file()) == executables
    assert '--json' in shell(in_installed + 'rosrun deformable_cobot classify_files --help')
    assert 'scan_id' in shell(in_installed + 'rosmsg show deformable_cobot/View')
    assert '/classifier' in shell(in_installed + 'roslaunch deformable_cobot sim.launch --nodes')
    # Nothing that was installed leads back into the checkout.
    for folder, _, files in os.walk(tmp_path / 'install'):
        for file in files:
            path = os.path.join(folder, file)
            assert not os.path.islink(path) or not os.path.realpath(path).startswith(str(checkout)), path


@pytest.mark.built
@pytest.mark.timeout(600)
def test_builds_where_another_python_comes_first(shell, checkout, tmp_path):
    (tmp_path / 'bin').mkdir()
    for name in ('python', 'python3'):
        program = tmp_path / 'bin' / name
        program.write_text(PYTHON_OF_ANOTHER)
        program.chmod(0o755)
    path = f'{tmp_path}/bin:{os.environ["PATH"]}'
    shell(f'{checkout}/setup/catkin {tmp_path}/workspace', timeout_s=500, PATH=path)
    sourced = f'source {tmp_path}/workspace/devel/setup.bash && '
    assert 'scan_id' in shell(sourced + 'rosmsg show deformable_cobot/View', PATH=path)
