"""The page that `scan --save` writes, in headless Chromium without a network."""

import os
import pathlib

import pytest

import browser

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

RED = 'r > 150 && r > 1.6 * g && r > 1.6 * b'
YELLOW = 'r > 180 && g > 150 && b < 110'
DRAWN = 'Math.abs(r - 0x20) + Math.abs(g - 0x24) + Math.abs(b - 0x2a) > 60'


@pytest.mark.skipif(not browser.program(), reason='no Chromium: apt-get install chromium')
def test_the_page_is_drawn_turns_and_asks_for_nothing(launch, executable, shelf, tmp_path):
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.wait_for_service('measure_deformation', timeout_s=60)
    graph.hold('medium-can', squeeze_m=0.010, seed=1)
    folder = shelf / 'can'
    printed = graph.core.output(executable('scan'), '--views', 3, '--save', folder, timeout_s=60)
    assert 'dented: ' in printed
    file = folder / 'scan.html'
    assert file.stat().st_size < 3_000_000
    page = browser.Page(tmp_path, file.as_uri())
    try:
        check(page, printed)
    finally:
        page.close()


def check(page, printed):
    before = page.picture()
    browser_picture(before, 'page.png')
    assert page.count(before, DRAWN) > 5000, 'the object is drawn'
    assert page.count(before, RED) > 100, 'its dent is red'
    assert page.count(before, YELLOW) > 20, 'an arrow points to it'
    words = page.evaluate('document.body.innerText')
    assert 'medium-can' in words and 'dented: ' in words and 'mm' in words
    assert [line for line in printed.splitlines() if line.startswith('dented: ')][0] in words
    page.drag((300, 350), (520, 350))
    after = page.picture()
    browser_picture(after, 'page_turned.png')
    assert page.count(after, DRAWN) > 5000 and after != before, 'it turns'
    boxes = "document.querySelectorAll('#clouds input')"
    assert page.evaluate(f'{boxes}.length') == 5, 'the object, three views and the synthesised shape'
    page.evaluate(f'{boxes}[1].click()')
    assert page.count(page.picture(), DRAWN) > page.count(after, DRAWN), 'a view is shown on request'
    assert page.errors == []
    asked = [url for url in page.requests if not url.startswith(('data:', 'blob:'))]
    assert len(asked) == 1 and asked[0].startswith('file:'), asked


def browser_picture(picture, name):
    """Kept where the environment names a folder, to look at."""
    folder = os.environ.get('DEFORMABLE_COBOT_PICTURES')
    if folder:
        browser.save(picture, pathlib.Path(folder) / name)
