"""The page in a real browser, where one is installed: opened, dragged, clicked, randomized, and looked at."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("uvicorn")
pytest.importorskip("starlette")
from tests.browser import Browser, browser, missing
from tests.view.commands import viewing

REASON = missing()
pytestmark = pytest.mark.skipif(REASON is not None, reason=f"no browser: {REASON}")
NAME = '<img src=x onerror="window.broken = 1">'
PICTURES = "Number(document.getElementById('canvas').dataset.pictures || 0)"
SCRIPT = f"""
import usdsdg as rep

floor = rep.create.cube(position=(0, 0, -4), scale=8)
box = rep.create.cube(position=(0, 0, 0.5), scale=1, semantics=[("class", {NAME!r})])
rep.physics.collider(input_prims=floor)
rep.physics.rigid_body(input_prims=box)
rep.create.light(light_type="Dome", intensity=800)
camera = rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0.5), name="Front")
with rep.trigger.on_frame(name="turn"), box:
    rep.modify.pose(rotation=rep.distribution.uniform((0, 0, 0), (360, 360, 360)))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="written", rgb=True)
writer.attach(rep.create.render_product(camera, (64, 48)))
rep.orchestrator.run(num_frames=2)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("view")
    (folder / "script.py").write_text(SCRIPT)
    return folder


@pytest.fixture(scope="module")
def opened(folder) -> Iterator[Browser]:
    """The page of the script's first frame, with pictures of labels."""
    with viewing("script.py", folder=folder) as address, browser() as made:
        made.visit(address)
        made.until(f"return {PICTURES} > 0", seconds=100)
        made.press("3")
        made.until("return document.getElementById('canvas').dataset.mode === 'instances'")
        yield made


def drawn(opened: Browser) -> np.ndarray:
    """The picture in the canvas, (H, W) red."""
    values = opened.run(
        """const c = document.getElementById('canvas');
        const copy = new OffscreenCanvas(c.width, c.height).getContext('2d', { willReadFrequently: true });
        copy.drawImage(c, 0, 0);
        const values = copy.getImageData(0, 0, c.width, c.height).data;
        return [c.width, c.height, ...Array.from(values).filter((_, i) => i % 4 === 0)]"""
    )
    return np.array(values[2:], np.uint8).reshape(values[1], values[0])


def newer(opened: Browser, act) -> np.ndarray:
    """Act, and return the picture that comes of it."""
    before = opened.run(f"return {PICTURES}")
    act()
    opened.until(f"return {PICTURES} > {before}")
    return drawn(opened)


def test_the_page_opens_without_errors(opened):
    assert opened.run("return document.title") == "script.py – usdsdg view"
    assert opened.text("#frame") == "frame 0"
    assert opened.text("#triggers") == "turn"
    assert drawn(opened).std() > 10
    assert opened.run("return document.querySelectorAll('#modes button').length") == 6
    assert opened.errors() == []


def test_dragging_orbits(opened):
    before = drawn(opened)
    after = newer(opened, lambda: opened.drag("#canvas", 160, 40))
    assert (before.shape != after.shape) or (np.abs(before.astype(int) - after).mean() > 1)
    opened.press("h")


def test_a_click_selects_and_names_are_text(opened):
    opened.press("f")  # does nothing without a selection
    opened.click("#cameras button")
    opened.until("return document.querySelector('#cameras button').getAttribute('aria-pressed') === 'true'")
    opened.drag("#canvas", 0, 0)
    opened.until("return document.querySelector('#selection dl') !== null")
    assert NAME.lower() in opened.text("#selection").lower()
    assert opened.run("return window.broken === undefined && !document.querySelector('#selection img')")
    assert opened.errors() == []


def test_randomize_draws_other_poses(opened):
    before = drawn(opened)
    after = newer(opened, lambda: opened.click("#randomize"))
    assert before.shape == after.shape
    assert np.abs(before.astype(int) - after).mean() > 0.5
    assert opened.run("return document.getElementById('seed').value") == "2"


def test_the_script_goes_on_to_its_next_frame_and_its_writer_writes_nothing(opened, folder):
    opened.click("#next")
    opened.until("return document.getElementById('frame').textContent === 'frame 1'")
    opened.press("n")
    opened.until("return document.getElementById('frames').hidden")
    assert not (folder / "written").exists()


def test_keys_and_themes(opened):
    opened.press("?")
    assert opened.run("return document.getElementById('help').open")
    opened.press("Escape")
    before = opened.run("return document.documentElement.dataset.theme")
    opened.press("t")
    assert opened.run("return document.documentElement.dataset.theme") != before
    opened.press("t")
    for key, mode in (("5", "depth"), ("4", "amodal"), ("3", "instances")):
        opened.press(key)
        opened.until(f"return document.getElementById('canvas').dataset.mode === '{mode}'")
    assert opened.errors() == []


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize(("width", "columns"), [(1280, 2), (520, 1)])
def test_the_page_fits_wide_and_narrow_windows_in_both_themes(opened, width, columns, theme):
    opened.resize(width, 900)
    opened.run(f"document.documentElement.dataset.theme = '{theme}'")
    grid = "getComputedStyle(document.querySelector('main')).gridTemplateColumns"
    opened.until(f"return {grid}.split(' ').length === {columns}")
    assert opened.run("return document.documentElement.scrollWidth <= window.innerWidth")
    ground = np.asarray(opened.screenshot().convert("L"))[-5:, :8]
    assert (ground.mean() > 200) == (theme == "light")


def test_another_page_cannot_talk_to_the_viewer(opened, folder):
    address = opened.run("return location.href")
    (folder / "other.html").write_text("<!doctype html><title>other</title>")
    opened.open(folder / "other.html")
    tried = opened.run(
        f"""return Promise.all([
          fetch("{address}").then(() => "read", () => "refused"),
          new Promise(done => {{
            const socket = new WebSocket("{address.replace("http", "ws")}socket");
            socket.onopen = () => done("opened");
            socket.onerror = () => done("refused");
          }}),
        ])"""
    )
    assert tried == ["refused", "refused"]
    opened.visit(address)
    opened.until(f"return {PICTURES} > 0")


def test_a_dataset_opens_with_its_pictures(shown_dataset):
    shown_dataset.until("return document.querySelectorAll('#strip button').length === 2")
    shown_dataset.until("return [...document.querySelectorAll('#strip img')].every(each => each.naturalWidth > 0)")
    shown_dataset.press("Right")
    assert shown_dataset.text("#position").endswith("2 / 2")
    assert shown_dataset.errors() == []


@pytest.fixture
def shown_dataset(tmp_path) -> Iterator[Browser]:
    """Two frames of BasicWriter, opened by the command."""
    from tests.inspect.datasets import BasicFolder

    basic = BasicFolder(tmp_path / "data")
    for number in range(2):
        basic.rgb(number)
        basic.boxes("bounding_box_2d_tight", number, [(0, 3, 4, 30, 25, 0.25)])
        basic.depth(number, np.linspace(1, 4, 64 * 48).reshape(48, 64))
    with viewing("data", folder=tmp_path) as address, browser() as made:
        made.visit(address)
        yield made
