"""World w of the step that begins with frame k shows what frame k + w of a run of single frames shows."""

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

import usdsdg as rep
from tests.worlds import scenes
from tests.worlds.random_graphs import RandomGraph
from usdsdg.capture.worlds import WorldTap
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
    scenes.other_intervals,
    scenes.draws_of_several_nodes,
    scenes.scattered,
    scenes.scattered_without_collisions,
)


@pytest.fixture(autouse=True)
def _session():
    yield
    session.restart()


@pytest.mark.parametrize("build", [*SCENES, *map(RandomGraph, range(4))])
def test_each_world_shows_the_frame_of_its_number(build):
    pictures = scenes.compared(build, WORLDS, STEPS)
    assert isinstance(build, RandomGraph) or len(set(pictures)) > WORLDS  # the draws differ


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


def test_what_a_script_changes_between_steps_stays(tmp_path):
    def build():
        rep.create.light(light_type="dome")
        for name in ("Left", "Right"):
            UsdGeom.Cube.Define(rep.get_stage(), f"/{name}").AddTranslateOp().Set((0, 0, 0))
        with rep.trigger.on_frame(interval=WORLDS):
            rep.modify.pose(position=scenes.uniform((0, 1, -1), (0, 2, 1)), input_prims=["/Left", "/Right"])
        with rep.trigger.on_frame():
            rep.modify.pose(position_x=scenes.uniform(-1, 1), input_prims=["/Left", "/Right"])
        return rep.create.camera(position=(9, 0, 0), look_at=(0, 0, 0))

    def place(name):
        rep.get_stage().GetPrimAtPath(f"/{name}").GetAttribute("xformOp:translate").Set((0, -1.5, 0))

    scenes.begin(build)
    batches = []
    session.current().worlds = WorldTap(WORLDS - 1, ("distance_to_camera",), batches.append)
    rep.orchestrator.step()
    left = rep.get_stage().GetPrimAtPath("/Left").GetAttribute("xformOp:translate")
    first, other = left.Get()[0], batches[0].values.values[left.GetPrimPath()]["xformOp:translate"]
    assert np.isclose(first, other[0][0])  # world 0
    place("Right")
    rep.orchestrator.step()
    for path, y in (("/Left", left.Get()[1]), ("/Right", -1.5)):
        columns = batches[1].values.values[rep.get_stage().GetPrimAtPath(path).GetPath()]["xformOp:translate"]
        # Frames 2 and 3, of which the second one fires both triggers.
        assert columns[0][1] == pytest.approx(y)
        assert columns[1][1] >= 1.0


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


def test_a_node_that_does_not_run_again_need_not_be_able_to():
    """A cube looks at a point once in three frames, and then is moved there."""

    def build():
        rep.create.light(light_type="dome", intensity=500)
        cube = rep.create.cube(semantics=[("class", "cube")])
        with rep.trigger.on_frame(interval=WORLDS), cube:
            rep.modify.pose(look_at=(0, 2, 0))
        with rep.trigger.on_frame(), cube:
            rep.modify.pose(position=rep.distribution.sequence([(0, 2, 0), (1, 0, 0), (2, 0, 0)]))
        return rep.create.camera(position=(9, 0, 2), look_at=(0, 0, 0))

    scenes.compared(build, WORLDS, STEPS)


def test_what_a_stronger_layer_decides_is_the_same_in_all_worlds():
    """A randomizer that writes to a layer below the one that has the position moves nothing in frames, either."""

    def build():
        rep.create.light(light_type="dome", intensity=500)
        stage = rep.get_stage()
        below = Sdf.Layer.CreateAnonymous(".usda")
        stage.GetRootLayer().subLayerPaths.append(below.identifier)
        cubes = rep.create.cube(count=2, position=(0, 1, 0), semantics=[("class", "cube")])
        ball = rep.create.sphere(semantics=[("class", "ball")])
        camera = rep.create.camera(position=(9, 0, 2), look_at=(0, 0, 0))
        stage.SetEditTarget(below)
        with rep.trigger.on_frame():
            rep.modify.pose(position=scenes.uniform((0, -2, -1), (0, 2, 1)), input_prims=cubes)
            rep.modify.pose(look_at=cubes, input_prims=ball)
            rep.modify.attribute(
                "inputs:intensity", scenes.uniform(100, 900), input_prims="/Replicator/DomeLight_Xform/DomeLight"
            )
        return camera

    scenes.compared(build, WORLDS, STEPS)
