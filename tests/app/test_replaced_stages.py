"""New and opened stages while physics plays."""

import pytest
from pxr import Sdf, Usd, UsdGeom

import usdsdg as rep
from tests.physics.scenes import add, position
from usdsdg.app.app import get_app
from usdsdg.session import engines, stage_context
from usdsdg.session.timeline import get_timeline


def falling(stage: Usd.Stage) -> Usd.Prim:
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 5))
    get_timeline().play()
    for _ in range(3):
        get_app().update()
    assert position(ball)[2] < 5
    return ball


@pytest.fixture
def kept(stage):
    """The stage, which stays alive when another replaces it: Python refers to stages weakly."""
    cache = Usd.StageCache()
    cache.Insert(stage)
    yield stage
    cache.Clear()


@pytest.fixture(autouse=True)
def no_capture(stage):
    rep.orchestrator.set_capture_on_play(False)


def test_a_new_stage_while_physics_plays_leaves_the_former_one_as_it_was(kept):
    ball = falling(kept)
    new = stage_context.new_stage()
    assert position(ball)[2] == 5
    assert not get_timeline().is_playing()
    falling(new)


def test_a_new_stage_while_physics_plays_needs_no_one_who_holds_the_former(stage):
    falling(stage_context.new_stage())
    for _ in range(2):
        falling(stage_context.new_stage())


@pytest.mark.parametrize("again", [True, False])
def test_a_stage_is_opened_while_physics_plays(stage, tmp_path, again):
    for name in "ab":
        source = Usd.Stage.CreateNew(str(tmp_path / f"{name}.usda"))
        UsdGeom.SetStageUpAxis(source, "Z")
        UsdGeom.Xform.Define(source, "/World")
        source.Save()
    opened = stage_context.open_stage(tmp_path / "a.usda")
    falling(opened)
    opened = stage_context.open_stage(tmp_path / f"{'a' if again else 'b'}.usda")
    # What the script had authored was never saved, and physics brings none of it back.
    assert not opened.GetPrimAtPath("/World/ball")
    falling(opened)


def test_a_step_listener_may_replace_the_stage(kept):
    steps = []

    def replace(dt: float) -> None:
        steps.append(dt)
        stage_context.new_stage()

    unsubscribe = engines.subscribe_step(replace)
    ball = add(kept, "/World/ball", "Sphere", at=(0, 0, 5))
    get_timeline().play()
    get_app().update()
    unsubscribe()
    assert len(steps) == 1
    assert position(ball)[2] == 5
    falling(stage_context.current_stage())


def test_a_layer_that_is_gone_needs_no_restoring(stage):
    layer = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 5))
    stage.SetEditTarget(layer)
    get_timeline().play()
    get_app().update()
    stage.SetEditTarget(stage.GetRootLayer())
    stage.GetRootLayer().subLayerPaths.clear()
    del layer
    get_timeline().stop()
    assert position(ball)[2] == 5
