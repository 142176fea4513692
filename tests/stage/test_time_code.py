"""Time codes of times, and values of many attributes at one."""

from fractions import Fraction

import pytest
from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.time_code import time_code_at, values_at


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


@pytest.mark.parametrize("rate", [24, 25, 30, 60, 120])
@pytest.mark.parametrize("updates", [24, 30, 60, 90])
def test_sums_of_steps_are_the_codes_of_samples(rate, updates):
    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(rate)
    time, apart = 0.0, 0
    for step in range(1, 3000):
        time += 1.0 / updates
        exact = Fraction(step * rate, updates)
        apart += time * rate != float(exact)
        code = time_code_at(time, stage).GetValue()
        if exact.denominator in (1, 2, 4, 5, 10):  # as people write codes
            assert code == float(exact)
        assert code == pytest.approx(float(exact), abs=1e-9)
    assert apart, "the products themselves are not"


def test_codes_between_samples_stay_what_they_are():
    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(1.0)
    for time in (1 / 3, 0.1234567, 5.9999995, -2 / 7, 1e18, float("inf")):
        assert time_code_at(time, stage).GetValue() == time
