"""What `make setup` says where it cannot go on."""

import os
import subprocess

import pytest


@pytest.fixture
def install(checkout, tmp_path):
    """Runs setup/install with stand-ins for some of the system's programs; returns exit code and what it printed."""
    def run(**stand_ins):
        for name, script in stand_ins.items():
            program = tmp_path / name.replace('_', '-')
            program.write_text(f'#!/bin/bash\n{script}\n')
            program.chmod(0o755)
        done = subprocess.run([checkout / 'setup' / 'install'], env={**os.environ, 'PATH': f'{tmp_path}:{os.environ["PATH"]}'},
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


def test_is_content_where_nothing_is_missing(install):
    assert install() == (0, '')
