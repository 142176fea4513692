"""`rep.preview`: what is drawn, and that a run does not notice."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Usd

import usdsdg as rep
from usdsdg import errors
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.cameras import default_view

BOXES = "bounding_box_2d_tight"


def scene():
    """Two labeled shapes in front of a camera, and its path."""
    rep.create.cube(position=(-1, 0, 0), semantics=[("class", "crate")])
    rep.create.sphere(position=(1, 0, 0), semantics=[("class", "ball")])
    return rep.create.camera(position=(0, -6, 0), look_at=(0, 0, 0))


def pixels(*arguments, **options) -> np.ndarray:
    return np.asarray(rep.preview(*arguments, **options)).astype(int)


def run(folder: Path, look) -> dict[str, bytes]:
    """Make three frames with random poses, blur and motion vectors, call `look()` between all steps; return the files.

    A label that comes before the others by name is added after the first look: ids must not tell that there was one.
    """
    session.restart()
    rep.set_global_seed(7)
    new_stage()
    camera = scene()
    look()
    rep.create.cone(position=(0, 0, 1.5), semantics=[("class", "aardvark")])
    with rep.trigger.on_frame(), rep.get.prims(semantics=[("class", "ball")]):
        rep.modify.pose(position=rep.distribution.uniform((0, 0, -1), (2, 0, 1)))
    rep.settings.set_render_pathtraced(2)
    rep.settings.carb_settings("/omni/replicator/captureMotionBlur", True)
    writer = rep.writers.get("BasicWriter")
    writer.initialize(
        output_dir=str(folder), rgb=True, semantic_segmentation=True, motion_vectors=True, bounding_box_2d_tight=True
    )
    writer.attach(rep.create.render_product(camera, (24, 16)))
    for _ in range(3):
        look()
        rep.orchestrator.step()
    look()
    rep.orchestrator.wait_until_complete()
    return {
        os.path.relpath(os.path.join(root, name), folder): Path(root, name).read_bytes()
        for root, _, names in os.walk(folder)
        for name in names
    }


def test_a_run_has_the_same_files_with_and_without_previews(tmp_path, stage):
    plain = run(tmp_path / "plain", lambda: None)
    looked = run(tmp_path / "looked", lambda: rep.preview(resolution=(16, 16), labels=["bounding_box_3d"]))
    assert sum(name.endswith(".png") for name in plain) >= 6
    assert {name: data for name, data in plain.items() if ".usdsdg" not in name} == {
        name: data for name, data in looked.items() if ".usdsdg" not in name
    }
    records = [name for name in plain if "frame" in name and ".usdsdg" in name]
    assert [plain[name] for name in records] == [looked[name] for name in records]


def test_a_preview_leaves_the_stage_and_its_listeners_alone(stage):
    scene()
    before = stage.GetRootLayer().ExportToString(), stage.GetSessionLayer().ExportToString()
    rep.preview(resolution=(8, 8))
    assert (stage.GetRootLayer().ExportToString(), stage.GetSessionLayer().ExportToString()) == before
    assert not stage.GetPrimAtPath(default_view.ROOT)


def test_without_a_camera_the_whole_scene_is_framed(stage):
    scene()
    shown = pixels(resolution=(60, 40), labels="instance_segmentation") - pixels(resolution=(60, 40), labels=())
    rows, columns = np.nonzero(np.abs(shown).sum(axis=2) > 30)
    assert len(rows) > 100
    assert rows.min() > 0
    assert columns.min() > 0
    assert rows.max() < 39
    assert columns.max() < 59


def test_boxes_are_drawn_where_the_annotator_has_them(stage):
    camera = scene()
    product = rep.create.render_product(camera, (120, 80))
    annotator = rep.annotators.get(BOXES)
    annotator.attach(product)
    rep.orchestrator.step()
    boxes = annotator.get_data()["data"]
    changed = np.abs(pixels(product, labels=BOXES) - pixels(product, labels=())).sum(axis=2) > 60
    assert len(boxes) == 2
    for box in boxes:
        left, top, right, bottom = (int(box[name]) for name in ("x_min", "y_min", "x_max", "y_max"))
        assert changed[bottom - 1 : bottom + 2, left:right].any(axis=0).all()
        assert changed[top + 15 : bottom, right - 1 : right + 2].any(axis=1).all()
        assert not changed[top + 15 : bottom - 3, left + 3 : right - 3].any()


def test_the_corners_of_solids_are_where_the_camera_sees_them(stage):
    camera = scene()
    # The crate is a cube of 1 m around (-1, 0, 0): its near face is 5.5 m before the camera, whose lens is the default.
    prim = stage.GetPrimAtPath(camera.prims[0])
    lens = next(each for each in Usd.PrimRange(prim) if each.GetTypeName() == "Camera")
    focal = 120 * lens.GetAttribute("focalLength").Get() / lens.GetAttribute("horizontalAperture").Get()
    drawn = pixels(camera, (120, 80), labels="bounding_box_3d") - pixels(camera, (120, 80), labels=())
    for x in (-1.5, -0.5):
        for z in (-0.5, 0.5):
            column, row = 60 + focal * x / 5.5, 40 - focal * z / 5.5
            around = np.abs(drawn[int(row) - 1 : int(row) + 2, int(column) - 1 : int(column) + 2]).sum(axis=2)
            assert around.max() > 60


def test_samples_are_path_traced_and_lights_of_the_stage_are_used(stage):
    camera = scene()
    rep.create.light(light_type="Sphere", intensity=0.0)
    assert pixels(camera, (8, 8), labels=(), samples=2).max() == 0


def test_a_picture_is_a_png_a_file_and_an_array(tmp_path, stage):
    picture = rep.preview(scene(), (16, 12), labels=())
    picture.save(tmp_path / "look.png")
    (tmp_path / "shown.png").write_bytes(picture._repr_png_())
    assert picture.size == (16, 12)
    for name in ("look.png", "shown.png"):
        assert np.array_equal(np.asarray(Image.open(tmp_path / name)), np.asarray(picture))


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"labels": ["bounding_box_2d_tigt"]}, errors.AnnotatorError, "Did you mean 'bounding_box_2d_tight'"),
        ({"labels": "boxes"}, errors.AnnotatorError, "It may be semantic_segmentation"),
        ({"resolution": (0, 3)}, errors.RenderError, "0 x 3"),
        ({"resolution": 5}, errors.ArgumentError, "width, height"),
        ({"samples": 0}, errors.ArgumentError, "preview: samples is 0"),
        ({"camera": "/World/none"}, errors.BadPrim, "/World/none is not on the stage"),
        ({"camera": []}, errors.ArgumentError, "0 prims"),
        ({}, errors.StageError, "no visible geometry"),
    ],
)
def test_bad_arguments_have_one_error(stage, options, error, words):
    with pytest.raises(error, match=words):
        rep.preview(**options)


def test_a_preview_of_a_lens_without_a_focal_length_says_what_it_must_be(stage):
    with pytest.raises(errors.RenderError, match=r"focalLength -5.0 \(it must be above 0\)"):
        rep.preview(rep.create.camera(position=(0, -6, 0), focal_length=-5))


def test_tiles_have_no_preview(stage):
    cameras = [rep.create.camera(position=(0, -6, z)) for z in (0, 1)]
    with pytest.raises(errors.Unsupported, match="tiles"):
        rep.preview(rep.create.render_product_tiled(cameras, (8, 8)))
