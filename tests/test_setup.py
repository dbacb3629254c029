"""What `make setup` says where it cannot go on."""

import os
import subprocess

import pytest


@pytest.fixture
def install(checkout, tmp_path):
    """Runs setup/install with stand-ins for some of the system's programs; returns exit code and what it printed."""
    def run(os_release=None, skip='', arguments=(), **stand_ins):
        variables = {'SETUP_SKIP_PACKAGES': skip}
        if os_release:
            (tmp_path / 'os-release').write_text(os_release)
            variables['OS_RELEASE'] = str(tmp_path / 'os-release')
        for name, script in stand_ins.items():
            program = tmp_path / name.replace('_', '-')
            program.write_text(f'#!/bin/bash\n{script}\n')
            program.chmod(0o755)
        done = subprocess.run([checkout / 'setup' / 'install', *arguments], env={**os.environ, **variables, 'PATH': f'{tmp_path}:{os.environ["PATH"]}'},
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout
    return run


def test_names_the_command_for_root(install):
    code, printed = install(id='echo 1000', sudo='exit 1', dpkg_query='exit 1')
    assert code == 1
    assert 'needs root' in printed
    assert 'apt-get install --yes --no-install-recommends' in printed and 'catkin' in printed


def test_refuses_an_old_cargo(install):
    code, printed = install(dpkg_query='echo -n installed', cargo='echo "cargo 1.63.0 (somewhere)"')
    assert code == 1
    assert 'cargo 1.90 or later is needed, 1.63.0 was found' in printed


def test_refuses_a_missing_cargo(install):
    code, printed = install(dpkg_query='echo -n installed', cargo='exit 127')
    assert code == 1
    assert 'none was found' in printed


@pytest.mark.built
@pytest.mark.parametrize('package, cleaned', [('ros-std-msgs', True), ('chromium', False)])
def test_messages_compiled_before_their_definitions_came_are_compiled_again(install, tmp_path, package, cleaned):
    code, printed = install(id='echo 0', dpkg_query=f'[ "$3" = {package} ] || echo -n installed', apt_get='',
                            cargo=f'echo "cargo 1.95.0 (somewhere)"; echo "$@" >>{tmp_path}/calls', arguments=[package])
    assert code == 0, printed
    assert f'setup: installing {package}' in printed
    assert ('clean --quiet --release --package rosrust_msg' in (tmp_path / 'calls').read_text()) == cleaned


def test_a_build_without_message_definitions_says_what_to_run(checkout, tmp_path):
    script = tmp_path / 'script'
    subprocess.run(['rustc', '--edition=2024', '-o', script, checkout / 'msg' / 'build.rs'], check=True)
    (tmp_path / 'b' / 'std_srvs').mkdir(parents=True)

    def errors(path):
        printed = subprocess.run([script], env={'ROSRUST_MSG_PATH': path}, check=True, stdout=subprocess.PIPE, text=True).stdout
        return [line for line in printed.splitlines() if line.startswith('cargo::error=')]
    # A package may be in either of two places.
    error, = errors(f'{tmp_path}/a/std_srvs:{tmp_path}/a/std_msgs:{tmp_path}/b/std_srvs:{tmp_path}/b/std_msgs')
    assert 'missing: std_msgs. Run `make setup`' in error
    assert errors(f'{tmp_path}/a/std_srvs:{tmp_path}/b/std_srvs') == []


needs_no_opt = pytest.mark.skipif(os.path.exists('/opt/ros/noetic/setup.bash'), reason='/opt/ros/noetic comes first')


@needs_no_opt
@pytest.mark.parametrize('id_, version', [('debian', '11'), ('debian', '12'), ('debian', '13'), ('ubuntu', '22.04')])
def test_knows_the_systems_whose_archive_has_noetic(install, id_, version):
    code, printed = install(os_release=f'ID={id_}\nVERSION_ID="{version}"\n', id='echo 1000', sudo='exit 1', dpkg_query='exit 1')
    assert code == 1
    # Debian 13's catkin does without it, and then nothing sets ROS_PACKAGE_PATH.
    assert 'apt-get install' in printed and ' ros-environment ' in printed


@needs_no_opt
def test_another_system_is_told_what_to_bring_and_how_to_go_on(install, checkout):
    fedora = 'ID=fedora\nVERSION_ID=41\nPRETTY_NAME="Fedora Linux 41"\n'
    code, printed = install(os_release=fedora)
    assert code == 1
    assert 'Fedora Linux 41 is not known here' in printed and 'SETUP_SKIP_PACKAGES=1' in printed
    for package in (checkout / 'setup' / 'packages' / 'archive.txt').read_text().split():
        assert package in printed
    assert install(os_release=fedora, skip='1') == (0, '')


@needs_no_opt
@pytest.mark.parametrize('version, words', [('20.04', 'ros-noetic-ros-base'), ('24.04', 'Containerfile')])
def test_ubuntus_without_ros_are_told_where_it_comes_from(install, version, words):
    code, printed = install(os_release=f'ID=ubuntu\nVERSION_ID="{version}"\n')
    assert code == 1
    assert words in printed


def test_is_content_where_nothing_is_missing(install):
    assert install() == (0, '')
