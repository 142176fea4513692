"""A new stage for each test."""

import pytest
from pxr import UsdGeom


@pytest.fixture
def y_up_stage(stage):
    """A new stage with Y up and centimeters."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return stage
