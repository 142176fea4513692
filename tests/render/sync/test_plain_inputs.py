"""Edits of shader inputs again and again, on a stage without time samples, give the materials of a new extraction."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

from tests.render.sync.fresh_materials import assert_fresh, rows
from usdsdg.stage.materials import define_mdl, set_input
from usdsdg_render.sync.extract import SceneExtractor

COLORS = ((0.1, 0.9, 0.2), (0.0, -1.0, 0.5), (2000.0, 0.1, 0.1), (0.4, float("nan"), 0.8))
AUTHORED = {
    "diffuse_color_constant": (0.3, 0.4, 0.5),
    "diffuse_tint": (1.0, 1.0, 1.0),
    "albedo_brightness": 1.0,
    "albedo_desaturation": 0.0,
    "reflection_roughness_constant": 0.5,
}
LOOKS = [f"/Looks/m{k}" for k in range(3)]


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    for k, path in enumerate(LOOKS):
        material = define_mdl(stage, path, "OmniPBR.mdl")
        for name, value in AUTHORED.items():
            set_input(material.GetPrim(), name, value)
        for name in (f"/World/a{k}", f"/World/b{k}"):
            ball = UsdGeom.Sphere.Define(stage, name)
            ball.AddTranslateOp().Set((k, 0, 0))
            UsdShade.MaterialBindingAPI.Apply(ball.GetPrim()).Bind(material)
    return stage


def _number(name: str, *values: object) -> Callable[[Usd.Prim, int], object]:
    return lambda prim, k: set_input(prim, name, values[k % len(values)])


def _connect(prim: Usd.Prim, k: int) -> None:
    own = UsdShade.Shader(prim.GetChild("Shader")).GetInput("diffuse_color_constant")
    shared = UsdShade.Material(prim).CreateInput("color", Sdf.ValueTypeNames.Color3f)
    shared.Set(COLORS[k % 2])
    if k % 3 == 2:
        own.ClearSources()
    else:
        own.ConnectToSource(shared)


def _clear(prim: Usd.Prim, k: int) -> None:
    prim.GetChild("Shader").GetAttribute("inputs:diffuse_color_constant").Clear()


def _bind_another(prim: Usd.Prim, k: int) -> None:
    ball = prim.GetStage().GetPrimAtPath(f"/World/b{k % 3}")
    UsdShade.MaterialBindingAPI(ball).Bind(UsdShade.Material(prim))


def _convert(prim: Usd.Prim, k: int) -> None:
    color = prim.GetChild("Shader").GetAttribute("inputs:diffuse_color_constant")
    color.SetColorSpace(("srgb_rec709_scene", "lin_rec709_scene", "lin_ap1_scene")[k % 3])


def _move(prim: Usd.Prim, k: int) -> None:
    prim.GetStage().GetAttributeAtPath("/World/a0.xformOp:translate").Set((k, 1, 0))


def _add(prim: Usd.Prim, k: int) -> None:
    UsdGeom.Cube.Define(prim.GetStage(), f"/World/c{k % 5}")


VALUES = [
    *[_number("diffuse_color_constant", *COLORS)] * 6,
    *[_number("reflection_roughness_constant", 0.1, 0.8, 1.5)] * 2,
    _number("diffuse_tint", (1.0, 1.0, 1.0), (0.5, 0.2, 1.0)),
    _number("albedo_brightness", 1.0, 0.5),
    _number("albedo_desaturation", 0.0, 0.5),
    _move,
]
OTHERS = [_connect, _clear, _bind_another, _add, _convert]


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("seed", range(4))
def test_the_materials_are_those_of_a_new_extraction(seed, stage):
    rng = np.random.default_rng(seed)
    extractor = SceneExtractor(stage)
    for _ in range(50):
        edits = OTHERS if rng.random() < 0.1 else VALUES
        for _ in range(rng.integers(1, 4)):
            prim = stage.GetPrimAtPath(LOOKS[rng.integers(3)])
            edits[rng.integers(len(edits))](prim, int(rng.integers(30)))
        assert_fresh(extractor, stage)


def test_a_color_that_is_connected_is_that_of_the_source(stage):
    extractor, prim = SceneExtractor(stage), stage.GetPrimAtPath(LOOKS[0])
    for k in range(6):
        set_input(prim, "diffuse_color_constant", COLORS[k % 2])
        if k == 3:
            _connect(prim, 1)
        assert_fresh(extractor, stage)


@pytest.mark.parametrize("edited", [LOOKS[0], f"{LOOKS[0]}/Shader", "/Looks"])
def test_a_color_space_counts_from_when_it_is_named(edited, stage):
    """That of the attribute itself, and that which a prim gives all below it."""
    prim, look, extractor = stage.GetPrimAtPath(edited), stage.GetPrimAtPath(LOOKS[0]), SceneExtractor(stage)
    Usd.ColorSpaceAPI.Apply(prim).CreateColorSpaceNameAttr("lin_rec709_scene")
    before = rows(extractor)[0]["base_color"].tolist()
    Usd.ColorSpaceAPI(prim).GetColorSpaceNameAttr().Set("srgb_rec709_scene")
    assert_fresh(extractor, stage)
    assert rows(extractor)[0]["base_color"].tolist() != before
    for k in range(4):
        set_input(look, "diffuse_color_constant", COLORS[k % 2])
        if k == 2:
            _convert(look, 2)
        assert_fresh(extractor, stage)


def test_a_color_that_was_changed_before_is_read_without_its_material(stage, monkeypatch):
    extractor = SceneExtractor(stage)
    shader = UsdShade.Shader.Get(stage, f"{LOOKS[0]}/Shader").GetInput("diffuse_color_constant")
    for color in ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)):
        shader.Set(color)
        extractor.update()
    monkeypatch.setattr("usdsdg_render.materials.network.Network.changed_fields", None)
    monkeypatch.setattr("usdsdg_render.materials.network.Network.read_fields", None)
    shader.Set((0.25, 0.5, 0.75))
    assert rows(extractor)[0]["base_color"].tolist() == [0.25, 0.5, 0.75]


def test_another_material_may_read_an_input_that_one_alone_has_read(stage):
    shader = UsdShade.Shader.Get(stage, f"{LOOKS[0]}/Shader")
    material = UsdShade.Material.Define(stage, "/Looks/other")
    material.CreateSurfaceOutput("mdl").ConnectToSource(shader.GetOutput("out"))
    extractor = SceneExtractor(stage)
    for color in ((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)):
        shader.GetInput("diffuse_color_constant").Set(color)
        extractor.update()
    UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/b2")).Bind(material)
    extractor.update()
    shader.GetInput("diffuse_color_constant").Set((0.7, 0.8, 0.9))
    assert_fresh(extractor, stage)


def test_materials_that_were_one_are_edited_apart(stage):
    """Copies of an asset share what was read, until one of them has a value of its own, be it the same one."""
    for name in ("/World/a0", "/World/b0"):
        ball = stage.GetPrimAtPath(name)
        copy = stage.DefinePrim(f"{name}/Look")
        copy.GetReferences().AddInternalReference(LOOKS[0])
        UsdShade.MaterialBindingAPI(ball).Bind(UsdShade.Material(copy))
    extractor = SceneExtractor(stage)
    colors = [AUTHORED["diffuse_color_constant"], *((0.1 * k, 0.5, 0.2) for k in range(4))]
    for k, color in enumerate(colors):
        for name in ("/World/a0", "/World/b0")[: 1 + k % 2]:
            set_input(stage.GetPrimAtPath(f"{name}/Look"), "diffuse_color_constant", color)
        assert_fresh(extractor, stage)


@pytest.fixture
def references():
    """A stage of three references to an asset with a ball and its material."""
    asset = Usd.Stage.CreateInMemory()
    asset.SetDefaultPrim(UsdGeom.Xform.Define(asset, "/Thing").GetPrim())
    material = define_mdl(asset, "/Thing/Look", "OmniPBR.mdl")
    set_input(material.GetPrim(), "diffuse_color_constant", AUTHORED["diffuse_color_constant"])
    ball = UsdGeom.Sphere.Define(asset, "/Thing/Ball")
    UsdShade.MaterialBindingAPI.Apply(ball.GetPrim()).Bind(material)
    stage = Usd.Stage.CreateInMemory()
    for k in range(3):
        stage.DefinePrim(f"/World/t{k}").GetReferences().AddReference(asset.GetRootLayer().identifier)
    yield stage
    del asset  # which keeps its layer


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_each_reference_of_an_asset_has_its_own_color(order, references):
    extractor = SceneExtractor(references)
    assert_fresh(extractor, references)
    for k in range(3):
        for n in order:
            color = (0.1 * n, 0.2 * k, 0.5)
            set_input(references.GetPrimAtPath(f"/World/t{n}/Look"), "diffuse_color_constant", color)
            assert_fresh(extractor, references)


def test_a_reference_does_not_get_the_color_of_one_whose_material_is_not_bound_any_more(references):
    extractor = SceneExtractor(references)
    assert_fresh(extractor, references)
    for n in (0, 1):
        UsdShade.MaterialBindingAPI(references.GetPrimAtPath(f"/World/t{n}/Ball")).UnbindAllBindings()
        assert_fresh(extractor, references)
    for n in range(3):
        set_input(references.GetPrimAtPath(f"/World/t{n}/Look"), "diffuse_color_constant", (0.1 * n, 0.2, 0.5))
        assert_fresh(extractor, references)
