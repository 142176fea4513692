"""World w of the step that begins with frame k shows what frame k + w of a run of single frames shows."""

import numpy as np
import pytest
from pxr import UsdGeom

import usdsdg as rep
from tests.worlds import scenes
from usdsdg.errors import ArgumentError
from usdsdg.session import session
from usdsdg.session.stage_context import open_stage
from usdsdg.session.timeline import get_timeline

WORLDS, STEPS = 3, 2
SCENES = (
    scenes.poses_and_colors,
    scenes.cameras_and_lights,
    scenes.materials_and_lists,
    scenes.orbits_and_nested_prims,
)


@pytest.fixture(autouse=True)
def _session():
    yield
    session.restart()


def boxes_of(frame):
    """By prim path, the box of `bounding_box_2d_tight`."""
    found = frame["bounding_box_2d_tight"]
    rows = found["data"]
    names = [f"{each}_{corner}" for corner in ("min", "max") for each in "xy"]
    return {path: [int(row[name]) for name in names] for path, row in zip(found["info"]["primPaths"], rows)}


@pytest.mark.parametrize("build", SCENES)
def test_each_world_shows_the_frame_of_its_number(build):
    frames = scenes.frames_of(build, WORLDS * STEPS)
    batches = scenes.worlds_of(build, WORLDS, STEPS)
    assert [batch.frame for batch in batches] == [0, WORLDS]
    pictures = []
    for batch in batches:
        arrays = {name: array.numpy() for name, array in batch.arrays.items()}
        for world in range(WORLDS):
            frame = frames[batch.frame + world]
            for name in ("rgb", "distance_to_camera", "semantic_segmentation", "instance_segmentation"):
                np.testing.assert_array_equal(arrays[name][world], scenes.plain(frame[name]), err_msg=name)
            boxes = dict(zip(batch.prims, arrays["bounding_box_2d_tight"][world].tolist()))
            assert {path: box[1:] for path, box in boxes.items() if box[0] > 0} == boxes_of(frame)
            assert all(box == [0, -1, -1, -1, -1] for box in boxes.values() if box[0] == 0)
            pictures.append(arrays["rgb"][world].tobytes())
    assert len(set(pictures)) > WORLDS  # the draws differ


def test_a_world_is_written_as_a_stage_that_shows_it(tmp_path):
    (batch,) = scenes.worlds_of(scenes.cameras_and_lights, WORLDS)
    batch.save_world(2, str(tmp_path / "world.usda"))
    with pytest.raises(ArgumentError, match="world 3 is none of 0 to 2"):
        batch.save_world(3, str(tmp_path / "none.usda"))
    session.restart()
    rep.set_global_seed(5)
    open_stage(str(tmp_path / "world.usda"))
    product = rep.create.render_product(batch.camera, scenes.SIZE)
    annotator = rep.annotators.get("distance_to_camera").attach(product)
    rep.orchestrator.step()
    np.testing.assert_allclose(annotator.get_data(), batch.arrays["distance_to_camera"].numpy()[2], rtol=1e-6)


def test_worlds_look_at_where_an_animated_prim_is():
    def build():
        rep.orchestrator.set_capture_on_play(False)
        rep.create.light(light_type="dome")
        target = UsdGeom.Cube.Define(rep.get_stage(), "/Target")
        move = target.AddTranslateOp()
        for time in range(9):
            move.Set((0, 0.5 * time, 0), float(time))
        get_timeline().set_current_time(6 / rep.get_stage().GetTimeCodesPerSecond())
        camera = rep.create.camera()
        with rep.trigger.on_frame(), camera:
            rep.modify.pose(position=scenes.uniform((6, -1, 0), (8, 1, 2)), look_at="/Target")
        return camera

    frames = scenes.frames_of(build, WORLDS)
    (batch,) = scenes.worlds_of(build, WORLDS)
    for frame, distance in zip(frames, batch.arrays["distance_to_camera"].numpy(), strict=True):
        np.testing.assert_array_equal(distance, scenes.plain(frame["distance_to_camera"]))
        assert np.isfinite(distance[scenes.SIZE[1] // 2, scenes.SIZE[0] // 2])
