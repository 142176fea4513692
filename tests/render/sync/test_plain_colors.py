"""Edits of displayColors again and again, on a stage without time samples, give the materials of a new extraction."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from tests.render.sync.fresh_materials import assert_fresh, rows
from tests.sampled_cases import sampled
from usdsdg.stage.materials import define_mdl
from usdsdg_render.sync.extract import SceneExtractor

BALLS = [f"/World/b{k}" for k in range(5)]
COLORS = ((0.1, 0.9, 0.2), (0.0, -1.0, 0.5), (2000.0, 0.1, 0.1), (0.4, float("nan"), 0.8), (0.5, 0.5, 0.5))


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    define_mdl(stage, "/Looks/shared", "OmniPBR.mdl")
    for k, path in enumerate(BALLS):
        ball = UsdGeom.Sphere.Define(stage, path) if k % 2 else _triangle(stage, path)
        ball.AddTranslateOp().Set((k, 0, 0))
        color = ball.CreateDisplayColorAttr([(0.1 * k, 0.2, 0.3)])
        assert UsdGeom.Primvar(color).GetInterpolation() == UsdGeom.Tokens.constant
    return stage


def _triangle(stage: Usd.Stage, path: str) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    return mesh


def _color(ball: Usd.Prim) -> Usd.Attribute:
    return UsdGeom.Gprim(ball).CreateDisplayColorAttr()


def _paint(ball: Usd.Prim, k: int) -> None:
    _color(ball).Set([(0.01 * k, 0.3, 0.7)])


def _paint_unusually(ball: Usd.Prim, k: int) -> None:
    _color(ball).Set([COLORS[k % len(COLORS)]])


def _paint_points(ball: Usd.Prim, k: int) -> None:
    primvar = UsdGeom.Primvar(_color(ball))
    primvar.SetInterpolation(("constant", "vertex")[k % 2])
    primvar.Set(Vt.Vec3fArray(3, Gf.Vec3f(0.1, 0.2, 0.02 * k)) if k % 3 else [(0.1, 0.2, 0.02 * k)])


def _index(ball: Usd.Prim, k: int) -> None:
    primvar = UsdGeom.Primvar(_color(ball))
    primvar.SetIndices(Vt.IntArray([0] * (1 + k % 3))) if k % 2 else primvar.BlockIndices()


def _fade(ball: Usd.Prim, k: int) -> None:
    UsdGeom.Gprim(ball).CreateDisplayOpacityAttr([0.02 * k])


def _clear(ball: Usd.Prim, k: int) -> None:
    _color(ball).Clear() if k % 2 else _color(ball).Block()


def _convert(ball: Usd.Prim, k: int) -> None:
    _color(ball).SetColorSpace(("srgb_rec709_scene", "lin_rec709_scene", "lin_ap1_scene")[k % 3])


def _convert_below(ball: Usd.Prim, k: int) -> None:
    world = Usd.ColorSpaceAPI.Apply(ball.GetParent())
    world.CreateColorSpaceNameAttr(("srgb_rec709_scene", "lin_rec709_scene")[k % 2])


def _bind(ball: Usd.Prim, k: int) -> None:
    api = UsdShade.MaterialBindingAPI.Apply(ball)
    api.Bind(UsdShade.Material.Get(ball.GetStage(), "/Looks/shared")) if k % 2 else api.UnbindAllBindings()


def _inherit(ball: Usd.Prim, k: int) -> None:
    """A gprim below that has no color of its own."""
    child = UsdGeom.Sphere.Define(ball.GetStage(), ball.GetPath().AppendChild("below"))
    child.CreateVisibilityAttr(("inherited", "invisible")[k % 2])


def _hide(ball: Usd.Prim, k: int) -> None:
    UsdGeom.Imageable(ball).CreateVisibilityAttr(("inherited", "invisible")[k % 2])


def _over(ball: Usd.Prim, k: int) -> None:
    """A stronger layer has a color, or none any more."""
    layer = ball.GetStage().GetSessionLayer()
    path = ball.GetPath().AppendProperty("primvars:displayColor")
    if k % 2 and not layer.GetAttributeAtPath(path):
        Sdf.JustCreatePrimAttributeInLayer(layer, path, Sdf.ValueTypeNames.Color3fArray)
        layer.GetAttributeAtPath(path).default = Vt.Vec3fArray([(0.02 * k, 0.9, 0.9)])
    else:
        layer.Clear()


def _emit(ball: Usd.Prim, k: int) -> None:
    ball.RemoveAppliedSchema("MeshLightAPI") if k % 2 else ball.AddAppliedSchema("MeshLightAPI")


VALUES = [*[_paint] * 8, *[_paint_unusually] * 2, _fade]
OTHERS = [_paint_points, _index, _clear, _convert, _convert_below, _bind, _inherit, _hide, _over, _emit]


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("seed", sampled(range(8), 3))
def test_the_materials_are_those_of_a_new_extraction(seed, stage):
    rng = np.random.default_rng(seed)
    extractor = SceneExtractor(stage)
    for _ in range(60):
        edits = OTHERS if rng.random() < 0.15 else VALUES
        for _ in range(rng.integers(1, 5)):
            edits[rng.integers(len(edits))](stage.GetPrimAtPath(BALLS[rng.integers(5)]), int(rng.integers(50)))
        assert_fresh(extractor, stage)


def test_a_time_sample_of_a_color_that_was_changed_before_counts(stage):
    extractor, color = SceneExtractor(stage), _color(stage.GetPrimAtPath(BALLS[1]))
    for k in range(3):
        color.Set([(0.1 * k, 0.5, 0.5)])
        extractor.update()
    color.Set([(0.9, 0.8, 0.7)], 5.0)
    extractor.update(Usd.TimeCode(5.0))
    assert rows(extractor)[1]["base_color"].tolist() == pytest.approx([0.9, 0.8, 0.7])


def test_colors_that_become_one_and_part_again_are_told_apart(stage):
    """Gprims of one color share a row of the table, which an edit of one of them must not change for the other."""
    extractor = SceneExtractor(stage)
    for k in range(12):
        for n, path in enumerate(BALLS):
            _color(stage.GetPrimAtPath(path)).Set([(0.1 * (n if k % 3 else n // 2), 0.02 * k, 0.3)])
        assert_fresh(extractor, stage)
    _color(stage.GetPrimAtPath(BALLS[0])).Set(_color(stage.GetPrimAtPath(BALLS[4])).Get())
    assert_fresh(extractor, stage)
    colors = rows(extractor)["base_color"].tolist()
    assert colors[0] == colors[4]
    assert len(set(map(tuple, colors))) == 4


def test_a_color_that_was_changed_before_is_read_without_its_gprim(stage, monkeypatch):
    extractor = SceneExtractor(stage)
    for color in ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)):
        _color(stage.GetPrimAtPath(BALLS[1])).Set([color])
        extractor.update()
    monkeypatch.setattr("usdsdg_render.sync.gprim_materials._read_shown", None)
    _color(stage.GetPrimAtPath(BALLS[1])).Set([(0.25, 0.5, 0.75)])
    assert rows(extractor)[1]["base_color"].tolist() == [0.25, 0.5, 0.75]


def test_gprims_below_follow_the_color_that_they_inherit(stage):
    """As a gprim below another one, which USD advises against."""
    extractor, ball = SceneExtractor(stage), stage.GetPrimAtPath(BALLS[1])
    _inherit(ball, 0)
    for k in range(4):
        _paint(ball, k)
        assert_fresh(extractor, stage)


def test_a_material_without_a_surface_shows_the_color_until_it_has_one(stage):
    extractor, ball = SceneExtractor(stage), stage.GetPrimAtPath(BALLS[1])
    material = UsdShade.Material.Define(stage, "/Looks/empty")
    UsdShade.MaterialBindingAPI.Apply(ball).Bind(material)
    for k in range(4):
        _paint(ball, k)
        assert_fresh(extractor, stage)
    surface = UsdShade.Shader.Define(stage, "/Looks/empty/Surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    for k in range(4):
        surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0.1 * k, 1, 0))
        _paint(ball, k)
        assert_fresh(extractor, stage)


@pytest.mark.parametrize("path", [BALLS[1], "/World"])
def test_a_gprim_that_gets_a_material_shows_it_whatever_its_color_was(path, stage):
    """Without any other edit than that of the binding, at the gprim or above it."""
    shared = UsdShade.Material.Get(stage, "/Looks/shared")
    other = UsdGeom.Cube.Define(stage, "/Other")  # which has the material all the time
    UsdShade.MaterialBindingAPI.Apply(other.GetPrim()).Bind(shared)
    api = UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path))
    extractor, ball = SceneExtractor(stage), stage.GetPrimAtPath(BALLS[1])
    for k in range(9):
        if k in (3, 6):
            api.Bind(shared) if k == 3 else api.UnbindAllBindings()
            assert_fresh(extractor, stage)
        _paint(ball, k)
        assert_fresh(extractor, stage)
