"""The graph on real captures of a real can."""

import pytest

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(180)]


@pytest.fixture
def captures(real):
    return real / 'captures' / 'can_a'


def test_names_the_real_can_without_being_asked(launch, captures):
    launch('recorded.launch', captures=captures)
    from deformable_cobot.msg import Classification
    answer = Listener('classification', Classification).next(timeout_s=60, accept=lambda answer: answer.complete)
    assert (answer.error, answer.label, answer.view_count) == ('', 'medium-can', 3)


def test_each_call_scans_again(launch, captures):
    graph = launch('recorded.launch', captures=captures)

    def scan():
        response = graph.scan()
        # The scan that is made at start may still be running.
        return None if 'already running' in response.error else response

    first, second = (wait_until(scan, 60, 'a scan of our own', period_s=0.5) for _ in range(2))
    assert [(r.error, r.result.label) for r in (first, second)] == [('', 'medium-can')] * 2
    assert first.result.scan_id != second.result.scan_id


def test_a_missing_folder_is_named(core, tmp_path):
    camera = core.run('rosrun', 'deformable_cobot', 'sim_camera', f'_captures:={tmp_path}/nothing')
    assert camera.wait(30) not in (0, None)
    assert f'{tmp_path}/nothing' in camera.printed()
