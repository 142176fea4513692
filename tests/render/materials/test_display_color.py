"""The displayColor and displayOpacity that gprims inherit."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg_render.materials.display_color import Shown, display_colors, display_opacities

T = Sdf.ValueTypeNames


def shown(stage, read, name):
    prim = UsdGeom.Sphere.Define(stage, "/World/sphere").GetPrim()
    return read([prim.GetAttribute(f"primvars:{name}")], Usd.TimeCode.Default())[0]


@pytest.mark.parametrize("kind", ["Color3f", "Color3d", "Float3", "Color3fArray"])
def test_one_color_of_an_xform_is_that_of_all_below_it(kind, recwarn):
    stage = Usd.Stage.CreateInMemory()
    value = [Gf.Vec3f(1, 0, 0)] if kind.endswith("Array") else (1, 0, 0)
    stage.DefinePrim("/World", "Xform").CreateAttribute("primvars:displayColor", getattr(T, kind)).Set(value)
    assert shown(stage, display_colors, "displayColor") == Shown((1.0, 0.0, 0.0))
    assert not recwarn.list


def test_one_opacity_of_an_xform_is_that_of_all_below_it(recwarn):
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/World", "Xform").CreateAttribute("primvars:displayOpacity", T.Float).Set(0.5)
    assert shown(stage, display_opacities, "displayOpacity") == Shown((0.5,))
    assert not recwarn.list


def test_words_are_no_color():
    forget_warnings()
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/World", "Xform").CreateAttribute("primvars:displayColor", T.String).Set("red")
    with pytest.warns(UsdsdgWarning, match="/World.primvars:displayColor: the value is a str, declared as string"):
        assert shown(stage, display_colors, "displayColor") == Shown(None)
