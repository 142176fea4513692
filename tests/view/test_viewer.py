"""The viewer without a browser: orbit, modes, selection, triggers, physics and cameras of a stage."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

import usdsdg as rep
from tests.view.pages import Page
from usdsdg.session import devices
from usdsdg.view.drawing import MODES
from usdsdg.view.paths import ENOUGH
from usdsdg.view.viewer import Viewer

BOX, FLOOR = "/World/Box", "/World/Floor"


def add_cube(stage, path: str, position, size: float, label: str | None = None):
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(*position))
    cube.AddScaleOp().Set(Gf.Vec3f(size))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    if label is not None:
        rep.modify.semantics([("class", label)], input_prims=path)
    return cube


@pytest.fixture
def scene(stage):
    """A labeled box that can fall, above a floor, and a camera that sees them from the front."""
    devices.use_device("cpu")
    add_cube(stage, FLOOR, (0, 0, -5), 8.0)
    box = add_cube(stage, BOX, (0, 0, 0.5), 1.0, "box")
    UsdPhysics.RigidBodyAPI.Apply(box.GetPrim())
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, -6, 1))
    camera.AddRotateXYZOp().Set(Gf.Vec3f(83, 0, 0))
    camera.CreateFocalLengthAttr(24.0)
    return stage


@pytest.fixture
def page(scene) -> Page:
    viewer = Viewer("a scene")
    return Page(viewer)


def test_a_page_is_told_what_the_stage_has(page):
    page.picture()
    told = page.values["scene"]
    assert told["title"] == "a scene"
    assert [each["path"] for each in told["cameras"]] == ["/World/Camera"]
    assert told["triggers"] == []
    assert told["notes"] == ["The stage has no light: a plain sky and a sun are added for the viewer."]
    assert page.values["state"]["frame"] is None


def test_every_mode_draws_another_picture(page):
    drawn = {mode: page.picture(do="mode", name=mode) for mode in MODES}
    for mode, image in drawn.items():
        assert image.shape == (48, 64, 3), mode
        assert image.std() > 5, mode
    assert page.pictures[-1][0]["mode"] == "normals"
    page.ask(do="mode", name="classes")
    page.picture()
    assert [name for name, _ in page.pictures[-1][0]["classes"]] == ["box"]


def test_colors_are_traced_until_they_are_good_and_then_no_more(page):
    page.ask(do="mode", name="paths")
    page.ask(do="size", width=32, height=24)
    turns_after = iter(range(20))
    page.until(lambda: page.pictures and page.pictures[-1][0].get("samples") == ENOUGH and next(turns_after) == 19)
    whole = [header for header, _ in page.pictures if header["mode"] == "paths" and header["width"] == 32]
    samples = [header["samples"] for header in whole]
    assert samples == sorted(set(samples))  # each is better than the one before, and the last is drawn once
    assert page.pictures[-1][1].mean() > 20  # lit by the sky that is added


def test_turning_and_zooming_change_the_picture_and_seeing_all_puts_it_back(page):
    at_first = page.picture(do="frame", what="all")
    turned = page.picture(do="turn", by=[0.3, 0.1])
    near = page.picture(do="zoom", by=0.5)
    assert np.abs(turned.astype(int) - at_first).mean() > 2
    assert np.abs(near.astype(int) - turned).mean() > 2
    again = page.picture(do="frame", what="all")
    page.picture(do="move", by=[0.2, 0.0])
    assert np.array_equal(page.picture(do="frame", what="all"), again)


def test_what_is_clicked_is_told_with_labels_and_pose(page):
    page.picture(do="through", camera="/World/Camera")
    page.ask(do="pick", at=[0.5, 0.5])
    page.until(lambda: page.values.get("selection"))
    selected = page.values["selection"]
    assert selected["path"] == BOX
    assert selected["labels"] == {"class": "box"}
    assert selected["position"] == pytest.approx([0, 0, 0.5])
    assert selected["rotation"] == pytest.approx([1, 0, 0, 0])
    assert selected["size"] == pytest.approx([1, 1, 1])
    assert selected["body"] == BOX
    assert selected["distance"] == pytest.approx(5.5, abs=0.05)
    # A line is drawn around it.
    assert (np.abs(page.picture().astype(int) - (255, 170, 0)).sum(axis=2) < 90).any()


def test_what_has_no_labels_is_told_by_its_own_path(page, scene):
    UsdGeom.Cube(scene.GetPrimAtPath(FLOOR)).CreateExtentAttr([(-9, -9, -9), (9, 9, 9)])  # not that of its size
    page.picture(do="through", camera="/World/Camera")
    page.ask(do="pick", at=[0.02, 0.98])
    page.until(lambda: page.values.get("selection"))
    assert page.values["selection"]["path"] == FLOOR
    assert page.values["selection"]["size"] == pytest.approx([8, 8, 8])
    assert "labels" not in page.values["selection"]
    page.ask(do="pick", at=None)
    page.until(lambda: page.values["selection"] is None)


def test_each_camera_has_a_small_picture(page):
    page.until(lambda: "/World/Camera" in page.cameras)
    assert page.cameras["/World/Camera"].std() > 5


def test_the_body_falls_while_physics_plays_and_reset_puts_it_back(page, scene):
    box = UsdGeom.Xformable(scene.GetPrimAtPath(BOX))
    box.GetPrim().GetAttribute("xformOp:translate").Set(Gf.Vec3d(0, 0, 3))
    height = lambda: box.GetPrim().GetAttribute("xformOp:translate").Get()[2]  # noqa: E731
    page.ask(do="play")
    page.until(lambda: height() < 2.5)
    assert page.values["state"]["playing"]
    page.ask(do="pause")
    page.until(lambda: not page.values["state"]["playing"])
    held = height()
    page.ask(do="step")
    page.until(lambda: height() < held)
    page.ask(do="reset")
    page.until(lambda: height() == 3)
    assert page.values["state"]["time"] == 0


def test_triggers_run_again_with_another_seed(scene):
    with rep.trigger.on_frame(name="places"), rep.get.prims(path_pattern=BOX):
        rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0.5), (2, 2, 0.5)))
    place = lambda: tuple(scene.GetPrimAtPath(BOX).GetAttribute("xformOp:translate").Get())  # noqa: E731
    seed, rows = rep.get_global_seed(), {}
    page = Page(Viewer("a scene"))
    for each in (7, 8, 7):
        page.picture(do="randomize", seed=each)
        rows.setdefault(each, []).append(place())
        assert page.values["state"]["seed"] == each
    assert page.values["scene"]["triggers"] == ["places"]
    assert rows[7][0] == rows[7][1] != rows[8][0]
    # The run itself draws what it would have drawn.
    assert rep.get_global_seed() == seed


def test_a_selected_thing_is_followed(page, scene):
    page.picture(do="through", camera="/World/Camera")
    page.ask(do="pick", at=[0.5, 0.5])
    page.until(lambda: page.values.get("selection"))
    scene.GetPrimAtPath(BOX).GetAttribute("xformOp:translate").Set(Gf.Vec3d(0.5, 0, 0.5))
    page.until(lambda: page.values["selection"]["position"][0] == 0.5)  # a new run of the loop reads the stage anew


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"do": "fly"}, "not understood"),
        ({"do": "turn", "by": [1]}, "not understood"),
        ({"do": "turn", "by": [float("1e9"), 0]}, "not understood"),
        ({"do": "size", "width": 100000, "height": 10}, "not understood"),
        ({"do": "mode", "name": "smell"}, "no picture is called 'smell'"),
        ({"do": "through", "camera": "/World/None"}, "there is no camera"),
        ({"do": "play", "and": "more"}, "not understood"),
    ],
)
def test_what_is_not_understood_is_said_and_the_viewer_goes_on(page, wish, said):
    page.ask(**wish)
    page.until(lambda: page.errors)
    assert said in page.errors[0]
    assert page.picture(do="turn", by=[0.1, 0]).any()


def test_a_node_that_fails_is_said_with_its_line(scene):
    with rep.trigger.on_frame(), rep.get.prims(path_pattern=BOX):
        rep.modify.attribute("radius", rep.distribution.uniform(0, 1))
    page = Page(Viewer("a scene"))
    page.ask(do="randomize", seed=1)
    page.until(lambda: page.errors)
    assert "test_viewer.py" in page.errors[0]


def test_an_empty_stage_is_shown_with_a_note(stage):
    devices.use_device("cpu")
    page = Page(Viewer("nothing"))
    page.picture()
    assert "The stage has no visible geometry." in page.values["scene"]["notes"]
