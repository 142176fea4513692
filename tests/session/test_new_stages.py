"""What new stages hold, and the stage that is open when a script starts."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdLux

from usdsdg.session import stage_context
from usdsdg.session.new_stages import DEFAULT_LIGHT, NewStage


@pytest.mark.parametrize(
    ("kind", "up", "units", "shines"),
    [
        (NewStage.KIT, "Y", 0.01, (0.0, -1.0, -1.0)),  # down, away from the viewer, who looks along -Z
        (NewStage.ISAAC, "Z", 1.0, (-1.0, 0.0, -1.0)),
    ],
)
def test_new_stages_are_those_of_the_application(stage, kind, up, units, shines):
    stage_context.use_new_stages(kind)
    made = stage_context.new_stage()
    assert made == stage_context.current_stage() != stage
    assert UsdGeom.GetStageUpAxis(made) == up
    assert UsdGeom.GetStageMetersPerUnit(made) == pytest.approx(units)
    assert str(made.GetDefaultPrim().GetPath()) == "/World"
    light = UsdLux.DistantLight(made.GetPrimAtPath(DEFAULT_LIGHT))
    assert light.GetIntensityAttr().Get() == 3000.0
    to_world = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(light.GetPrim()))
    assert -to_world[2, :3] == pytest.approx(np.array(shines) / np.sqrt(2))


def test_without_a_choice_new_stages_are_empty(stage):
    assert [str(prim.GetPath()) for prim in stage.Traverse()] == ["/World"]
    assert UsdGeom.GetStageUpAxis(stage) == "Z"


def test_an_application_starts_with_the_stage_that_was_opened(stage, tmp_path):
    file = str(tmp_path / "scene.usda")
    Usd.Stage.CreateNew(file).Save()
    opened = stage_context.open_at_start(file)
    assert stage_context.stage_at_start() == opened == stage_context.current_stage()
    stage_context.new_stage()
    assert stage_context.stage_at_start() != opened
