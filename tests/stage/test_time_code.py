"""Values of many attributes at one time code."""

import pytest
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.time_code import values_at


def test_many_values_are_those_of_each_attribute_unless_a_prim_is_gone():
    stage = Usd.Stage.CreateInMemory()
    cubes = [UsdGeom.Cube.Define(stage, f"/Cube_{number}") for number in range(3)]
    for number, cube in enumerate(cubes):
        cube.GetSizeAttr().Set(number, Usd.TimeCode(1))
    attributes = [*(cube.GetSizeAttr() for cube in cubes), cubes[0].GetPrim().GetAttribute("visibility")]
    assert values_at(attributes, Usd.TimeCode(1)) == [0.0, 1.0, 2.0, "inherited"]
    assert values_at([cubes[0].GetPrim().CreateAttribute("own", Sdf.ValueTypeNames.Int)], Usd.TimeCode(1)) == [None]
    stage.RemovePrim("/Cube_1")
    with pytest.raises(RuntimeError, match="expired"):
        values_at(attributes, Usd.TimeCode(1))
