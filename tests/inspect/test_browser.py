"""The page in a real browser, where one is installed: it is clicked, gets keys, and is looked at in two widths."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.browser import Browser, browser, missing
from tests.inspect.datasets import BasicFolder, picture, pose_object, write_pose
from usdsdg.inspect import inspect

REASON = missing()
pytestmark = pytest.mark.skipif(REASON is not None, reason=f"no browser: {REASON}")
EVIL = '<img src=x onerror="window.broken = 1">'
RED, GREEN = (200, 40, 40), (40, 200, 40)
BLACK = 40  # brightness below which a pixel is dark


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """Three frames of PoseWriter beside two of BasicWriter, with names that try to be tags."""
    root = tmp_path_factory.mktemp("page")
    for number in range(3):
        mug = pose_object(None, "mug", [0.1 * number, 0.0, -2.0], [0.4] * 3)
        evil = pose_object(None, EVIL, [-0.4, 0.0, -2.0], [0.3] * 3)
        write_pose(root / "poses", number, [mug, evil] if number else [mug])
        Image.new("RGB", (64, 48), GREEN if number == 1 else RED).save(root / "poses" / f"{number:06d}.png")
    basic = BasicFolder(root / EVIL.replace("/", ""))
    for number in range(2):
        basic.rgb(number)
        basic.boxes("bounding_box_2d_tight", number, [(0, 3, 4, 30, 25, 0.25)])
        basic.depth(number, np.linspace(1, 4, 64 * 48).reshape(48, 64))
    (root / "poses" / "000002.json").write_text("{")
    picture(root / "poses" / "000003.png")
    return inspect(root, root / "page.html")


@pytest.fixture(scope="module")
def shown() -> Iterator[Browser]:
    with browser() as made:
        yield made


@pytest.fixture
def opened(shown, page) -> Browser:
    shown.open(page)
    shown.until("return document.querySelectorAll('#strip button').length === 6")
    return shown


def position(opened: Browser) -> str:
    return opened.text("#position")


def choose(opened: Browser, name: str) -> None:
    """Click the small picture of a frame."""
    names = opened.run("return [...document.querySelectorAll('#strip button')].map(each => each.title)")
    opened.click(f"#strip button:nth-child({names.index(name) + 1})")
    assert position(opened).startswith(name)


def lower_edge(opened: Browser) -> tuple[int, ...]:
    """The color in the canvas at the lower edge of the picture, where no label is drawn."""
    opened.until("return [...document.querySelectorAll('#strip img')].every(each => !each.src || each.complete)")
    pixel = "const c = document.getElementById('canvas'); const d = c.getContext('2d')"
    return tuple(opened.run(f"{pixel}.getImageData(c.width / 2, c.height - 8, 1, 1).data; return [d[0], d[1], d[2]]"))


def test_a_page_opens_without_errors_and_shows_its_first_picture(opened):
    assert opened.run("return document.title").endswith("usdsdg inspect")
    assert position(opened).endswith("1 / 6")
    assert "PoseWriter, default format" in opened.text("#facts")
    assert "BasicWriter" in opened.text("#facts")
    # A bar, boxes, charts and problems are there to be seen.
    for part in ("#layers label", "#legend button", "#statistics svg", "#problems details"):
        assert opened.run(f"return document.querySelectorAll('{part}').length") >= 1, part
    assert opened.errors() == []


def test_names_that_look_like_tags_are_text(opened):
    assert opened.run("return window.broken === undefined")
    assert opened.run("return document.querySelectorAll('img[onerror], #legend img, #objects img').length") == 0
    assert EVIL in opened.text("#legend")
    choose(opened, "poses/000001")
    assert EVIL in opened.run("return document.getElementById('objects').textContent")
    assert opened.errors() == []


def test_keys_go_through_the_pictures(opened):
    for key, expected in (("Right", "2 / 6"), ("End", "6 / 6"), ("Left", "5 / 6"), ("Home", "1 / 6")):
        opened.press(key)
        assert position(opened).endswith(expected), key


def test_clicks_go_through_the_pictures_too(opened):
    opened.click("#next")
    assert position(opened).endswith("2 / 6")
    opened.click("#previous")
    assert position(opened).endswith("1 / 6")
    opened.click("#strip button:nth-child(3)")
    assert position(opened).endswith("3 / 6")


def test_the_canvas_shows_the_picture_of_the_frame(opened):
    for name, color in (("poses/000000", RED), ("poses/000001", GREEN)):
        choose(opened, name)
        opened.run("return new Promise(done => setTimeout(done, 150))")
        assert lower_edge(opened) == pytest.approx(color, abs=12), name


def test_layers_are_drawn_and_hidden_by_key_and_by_click(opened):
    before = opened.screenshot()
    opened.press("b")
    assert np.asarray(opened.screenshot()).tolist() != np.asarray(before).tolist()
    opened.press("b")
    assert opened.run("return document.getElementById('depth-scale').style.display") == "none"
    opened.press("d")
    assert opened.run("return document.getElementById('depth-scale').style.display") == "block"
    # The same by a click on its line.
    line = "[...document.querySelectorAll('#layers label')].findIndex(each => each.textContent.startsWith('Distance'))"
    opened.click(f"#layers label:nth-of-type({opened.run(f'return {line}') + 1}) input")
    assert opened.run("return document.getElementById('depth-scale').style.display") == "none"


def test_a_class_is_hidden_and_a_chart_filters_the_pictures(opened):
    opened.press("End")
    opened.click("#legend button:nth-child(1)")
    assert opened.run("return document.querySelector('#legend button').getAttribute('aria-pressed')") == "false"
    opened.click("#legend button:nth-child(1)")
    opened.run("document.querySelector('#statistics .classes').scrollIntoView()")
    opened.click("#statistics .classes button:nth-child(1)")
    assert " of 6: pictures with " in opened.text("#filter span")
    opened.press("Escape")
    assert opened.run("return document.getElementById('filter').hidden")


def test_a_problem_leads_to_its_picture(opened):
    opened.run("document.querySelectorAll('#problems details').forEach(each => { each.open = true; })")
    opened.run("document.querySelector('#problems a').scrollIntoView({ block: 'center' })")
    listed = opened.run("return document.querySelector('#problems a').parentElement.textContent")
    opened.click("#problems a")
    name = position(opened).split()[0]
    assert name.rsplit("/", 1)[-1] in listed


def test_the_pointer_tells_what_is_under_it(opened):
    choose(opened, "poses/000000")
    opened.point("#canvas", 0, 0)
    opened.until("return document.getElementById('tip').style.display === 'block'")
    assert opened.text("#tip").startswith("mug")


def test_help_opens_and_themes_change(opened):
    opened.press("?")
    assert opened.run("return document.getElementById('help').open")
    opened.press("Escape")
    assert not opened.run("return document.getElementById('help').open")
    before = opened.run("return document.documentElement.dataset.theme")
    opened.press("t")
    assert opened.run("return document.documentElement.dataset.theme") != before
    opened.press("t")


@pytest.mark.parametrize(("width", "columns"), [(1280, 2), (520, 1)])
def test_the_page_fits_wide_and_narrow_windows(shown, page, width, columns):
    shown.open(page, width=width, height=900)
    shown.until("return document.querySelectorAll('#strip button').length === 6")
    assert shown.run("return document.documentElement.scrollWidth <= window.innerWidth")
    grid = shown.run("return getComputedStyle(document.querySelector('main')).gridTemplateColumns")
    assert len(grid.split()) == columns
    seen = np.asarray(shown.screenshot().convert("L"))
    # The dark stage with the picture in it is on the screen.
    assert seen.shape[1] >= width - 40
    assert (seen < BLACK).mean() > 0.02
