"""A new stage for each test."""

import pytest
from pxr import UsdGeom

from usdsdg.graph.sampling import set_global_seed
from usdsdg.session.stage_context import new_stage


@pytest.fixture
def stage():
    """Z up, metres, with an empty /World."""
    set_global_seed(1)
    return new_stage()


@pytest.fixture
def y_up_stage(stage):
    """Y up, centimetres."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return stage
