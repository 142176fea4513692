"""Stages with time samples, in scripts and on the command line, are rendered at the time of the timeline."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg as rep
from tests.stage.geometry.characters import add_character
from usdsdg.cli.app import app
from usdsdg.session.stage_context import new_stage, open_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels

RATE = 24


def animated(stage):
    """A labeled box that moves from x = -2 to 2 in 24 time codes, a labeled character that bends, a static camera."""
    stage.SetTimeCodesPerSecond(RATE)
    box = UsdGeom.Cube.Define(stage, "/World/Box")
    box.CreateSizeAttr(1.0)
    move = box.AddTranslateOp()
    move.Set(Gf.Vec3d(-2, 0, 0), 0)
    move.Set(Gf.Vec3d(2, 0, 0), 24)
    add_labels(box.GetPrim(), {"class": ["box"]})
    add_character(stage, "/World/Man")
    man = stage.GetPrimAtPath("/World/Man")
    UsdGeom.Xformable(man).AddTranslateOp().Set(Gf.Vec3d(0, 0, 2))
    add_labels(man, {"class": ["man"]})
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTransformOp().Set(look_at_matrix((0, -12, 2), (0, 0, 2), up=(0, 0, 1)))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100.0))
    camera.CreateFocalLengthAttr(20.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(24)
    return stage


@pytest.fixture
def file(tmp_path):
    stage = Usd.Stage.CreateNew(str(tmp_path / "animated.usda"))
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    animated(stage).Save()
    return tmp_path / "animated.usda"


def attach(*names):
    product = rep.create.render_product("/World/Camera", (96, 64))
    return [rep.annotators.get(name).attach(product) for name in names]


def box_of(annotator, label):
    data = annotator.get_data()
    labels = {int(number): each["class"] for number, each in data["info"]["idToLabels"].items()}
    (row,) = [row for row in data["data"] if labels[int(row["semanticId"])] == label]
    return row


def test_images_masks_and_boxes_follow_the_timeline():
    animated(new_stage())
    tight, solid = attach("bounding_box_2d_tight", "bounding_box_3d")
    columns, heights, tops = [], [], []
    for code in (0, 12, 24):
        get_timeline().set_current_time(code / RATE)
        rep.orchestrator.step(delta_time=0.0)
        box = box_of(tight, "box")
        columns.append((box["x_min"] + box["x_max"]) / 2)
        man = box_of(solid, "man")
        heights.append(float(man["z_max"]))
        assert box_of(solid, "box")["transform"][3, 0] == pytest.approx(-2 + 4 * code / 24)
        tops.append(int(box_of(tight, "man")["y_min"]))
    assert columns[0] < columns[1] < columns[2]
    np.testing.assert_allclose([columns[0] + columns[2], 2 * columns[1]], 95, atol=1.5)
    assert heights[0] == pytest.approx(2.0)
    assert heights[0] > heights[1] > heights[2]
    assert tops[0] < tops[1] < tops[2], "the image shows the bent mesh too"


def test_a_playing_timeline_plays_the_animation(file):
    open_stage(file)
    timeline = get_timeline()
    assert (timeline.get_end_time(), timeline.get_time_codes_per_seconds()) == (1.0, RATE)
    (solid,) = attach("bounding_box_3d")
    timeline.play()
    positions = []
    for _ in range(4):
        rep.orchestrator.step(pause_timeline=False)
        positions.append(box_of(solid, "box")["transform"][3, 0])
    timeline.stop()
    np.testing.assert_allclose(np.diff(positions), 4 / 24, atol=1e-6)


@pytest.mark.parametrize("rate", [24, 30, 60])
def test_each_frame_of_a_flip_book_shows_its_own_page(rate):
    """Visibility and whole numbers are held until their next sample, which is due at the very code of a frame."""
    stage = animated(new_stage())
    stage.SetTimeCodesPerSecond(rate)
    pages = 26
    for page in range(pages):
        prim = UsdGeom.Cube.Define(stage, f"/World/Page_{page}").GetPrim()
        UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(0, -2, 2))
        visibility = UsdGeom.Imageable(prim).CreateVisibilityAttr()
        for code in range(pages):
            visibility.Set("inherited" if code == page else "invisible", code)
    number = stage.GetPrimAtPath("/World").CreateAttribute("number", Sdf.ValueTypeNames.Int)
    for code in range(pages):
        number.Set(code, code)
    (shown,) = attach("instance_id_segmentation")
    told = rep.annotators.get("Attribute", init_params={"prims": ["/World"], "attribute": "number"})
    told.attach(rep.create.render_product("/World/Camera", (96, 64)))
    get_timeline().play()
    for _ in range(20):
        rep.orchestrator.step()
        page = round(get_timeline().get_current_time() * rate)
        paths = set(shown.get_data()["info"]["idToLabels"].values())
        assert [path for path in paths if "Page" in path] == [f"/World/Page_{page}"]
        assert told.get_data().tolist() == [page]
    assert page == 19


def test_opening_an_animation_sets_the_time_to_its_start(file):
    stage = Usd.Stage.Open(str(file))
    stage.SetStartTimeCode(6)
    stage.Save()
    open_stage(file)
    assert get_timeline().get_current_time() == pytest.approx(6 / RATE)
    new_stage()
    assert get_timeline().get_current_time() == 0.0


def test_cameras_move_and_zoom_with_the_time():
    stage = animated(new_stage())
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    focal = camera.GetFocalLengthAttr()
    focal.Set(20.0, 0)
    focal.Set(40.0, 24)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Box")).GetOrderedXformOps()[0].GetAttr().Clear()
    (tight,) = attach("bounding_box_2d_tight")
    widths = []
    for code in (0, 24):
        get_timeline().set_current_time(code / RATE)
        rep.orchestrator.step(delta_time=0.0)
        row = box_of(tight, "box")
        widths.append(int(row["x_max"]) - int(row["x_min"]) + 1)
    assert widths[1] == pytest.approx(2 * widths[0], abs=2)


@pytest.mark.parametrize(("code", "x"), [(None, -2.0), (18, 1.0)])
def test_render_takes_a_time_code(file, tmp_path, code, x):
    time = [] if code is None else ["--time", str(code)]
    out = tmp_path / "out"
    command = ["render", str(file), str(out), "--width", "32", "--height", "24", "--spp", "1", "--quiet", *time]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    boxes = np.load(out / "bounding_box_3d_0000.npy")
    paths = json.loads((out / "bounding_box_3d_prim_paths_0000.json").read_text())
    assert boxes[paths.index("/World/Box")]["transform"][3, 0] == pytest.approx(x)
