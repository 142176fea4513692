"""Edits of `changing_stage` that change values alone, which are read without the rest of their prims."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from tests.render.sync.changing_stage import COLORS, EDITS, Edit
from usdsdg.stage.materials import define_mdl, set_input

LOOK = "/World/Looks/omni"
T = Sdf.ValueTypeNames


def _omni_pbr(edit: Callable[[Usd.Prim, int], object]) -> Edit:
    """Edit an OmniPBR on the ground, which is made where it is missing."""

    def edited(stage: Usd.Stage, k: int) -> None:
        prim = stage.GetPrimAtPath(LOOK)
        if not prim:
            material = define_mdl(stage, LOOK, "OmniPBR.mdl")
            prim = material.GetPrim()
            set_input(prim, "diffuse_color_constant", (0.3, 0.4, 0.5))
            UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath("/World/Ground")).Bind(material)
        edit(prim, k)

    return edited


def _number(name: str, *values: object) -> Edit:
    return _omni_pbr(lambda prim, k: set_input(prim, name, values[k % len(values)]))


def _paint_texture(prim: Usd.Prim, k: int) -> None:
    folder = Path(prim.GetStage().GetRootLayer().realPath).parent
    set_input(prim, "diffuse_texture", str(folder / f"{k % 3}.png") if k % 4 else "")


def _come_and_go(prim: Usd.Prim, k: int) -> None:
    """An input that is added, set, cleared and removed."""
    shader = prim.GetChild("Shader")
    if k % 4 == 3:
        shader.RemoveProperty("inputs:metallic_constant")
    elif k % 4 == 2 and shader.HasAttribute("inputs:metallic_constant"):
        shader.GetAttribute("inputs:metallic_constant").Clear()
    else:
        set_input(prim, "metallic_constant", 0.5 + 0.1 * (k % 5))


def _connect(prim: Usd.Prim, k: int) -> None:
    """A color from the material's interface, or the shader's own again."""
    own = UsdShade.Shader(prim.GetChild("Shader")).GetInput("diffuse_color_constant")
    shared = UsdShade.Material(prim).CreateInput("tint", T.Color3f)
    shared.Set(COLORS[k % 3])
    if k % 3 == 2:
        own.ClearSources()
    else:
        own.ConnectToSource(shared)


def _glow(prim: Usd.Prim, k: int) -> None:
    set_input(prim, "enable_emission", bool(k % 3))
    set_input(prim, "emissive_intensity", 100.0 * (k % 5))


def _paint_preview(prim: Usd.Prim, k: int) -> None:
    prim.GetChild("PreviewSurface").GetAttribute("inputs:diffuseColor").Set(COLORS[k % 3])


def _recolor_beads(stage: Usd.Stage, k: int) -> None:
    """A gprim below another one inherits its color."""
    if not stage.GetPrimAtPath("/World/Balls/b0/Bead"):
        bead = UsdGeom.Sphere.Define(stage, "/World/Balls/b0/Bead")
        bead.CreateRadiusAttr(0.2)
        bead.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.5))
    stage.GetAttributeAtPath("/World/Balls/b0.primvars:displayColor").Set([COLORS[k % 3]])


def _color_or_none(stage: Usd.Stage, k: int) -> None:
    attribute = stage.GetAttributeAtPath("/World/Balls/b1.primvars:displayColor")
    (attribute.Clear, attribute.Block, lambda: attribute.Set([COLORS[k % 3]]))[k % 3]()


def _colors_or_one(stage: Usd.Stage, k: int) -> None:
    """A color for each face, then one for all."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Parted"))
    interpolation = ("uniform", "constant")[k % 2]
    mesh.CreateDisplayColorPrimvar(interpolation).Set([COLORS[(n + k) % 3] for n in range(2 - k % 2)])


def _fade_points(stage: Usd.Stage, k: int) -> None:
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Parted"))
    mesh.CreateDisplayOpacityPrimvar("vertex").Set(np.linspace(0.1 * (k % 4), 1, 4).tolist())


def _unwrap(stage: Usd.Stage, k: int) -> None:
    corners = [Gf.Vec2f(u * (1 + k % 5), v) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
    stage.GetAttributeAtPath("/World/Ground.primvars:st").Set(corners)


def _warm(stage: Usd.Stage, k: int) -> None:
    lamp = UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lamp"))
    lamp.CreateEnableColorTemperatureAttr(bool(k % 4))
    lamp.CreateColorTemperatureAttr(2000.0 + 1000.0 * (k % 5))


ALL_EDITS: dict[str, Edit] = EDITS | {
    "an opacity": lambda stage, k: (
        UsdGeom.Gprim(stage.GetPrimAtPath("/World/Balls/b0")).CreateDisplayOpacityAttr().Set([0.3 + 0.2 * (k % 3)])
    ),
    "opacities of points": _fade_points,
    "colors of faces": _colors_or_one,
    "a color that comes and goes": _color_or_none,
    "a color of nested gprims": _recolor_beads,
    "texture coordinates": _unwrap,
    "an OmniPBR's color": _number("diffuse_color_constant", (0.1, 0.9, 0.2), (2000.0, 0.1, 0.1), (0.4, 0.4, 0.8)),
    "an OmniPBR's tint": _number("diffuse_tint", (0.5, 0.2, 1.0), (1.0, 1.0, 1.0)),
    "an OmniPBR's roughness": _number("reflection_roughness_constant", 0.1, 0.8, 0.4),
    "an OmniPBR's texture": _omni_pbr(_paint_texture),
    "an OmniPBR's texture scale": _number("texture_scale", (2.0, 1.0), (1.0, 3.0)),
    "an OmniPBR's opacity": _number("opacity_constant", 0.2, 0.6),
    "whether an OmniPBR has opacity": _number("enable_opacity", True, False),
    "an OmniPBR's input that comes and goes": _omni_pbr(_come_and_go),
    "an OmniPBR's connection": _omni_pbr(_connect),
    "an OmniPBR's emission": _omni_pbr(_glow),
    "a shader for other renderers": _omni_pbr(_paint_preview),
    "a material of a reference": lambda stage, k: stage.GetAttributeAtPath(
        "/World/Crates/c0/Look/Surface.inputs:diffuseColor"
    ).Set(COLORS[k % 3]),
    "a light's exposure": lambda stage, k: (
        UsdLux.LightAPI(stage.GetPrimAtPath("/World/Lamp")).CreateExposureAttr().Set(float(k % 4))
    ),
    "a light's temperature": _warm,
}
