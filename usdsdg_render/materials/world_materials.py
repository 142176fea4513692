"""Columns of `scene.MATERIAL` from inputs of shaders that have other values in each of many worlds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import Unsupported
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.materials.mdl.inputs import WHITE
from usdsdg_render.materials.mdl.material import mdl_name
from usdsdg_render.materials.network import Network, shader_id
from usdsdg_render.materials.shading import MAX_COLOR


class Rule(NamedTuple):
    """How an input becomes a column."""

    column: str
    # From the values (worlds, shaders, ...) of an input to the column's.
    convert: Callable[[np.ndarray, np.ndarray], np.ndarray]
    # What `convert` gets of each shader as its second argument, (shaders, numbers).
    constants: Callable[[Network, UsdShade.Shader], tuple[float, ...]] = lambda network, shader: ()


def _unit(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    return np.clip(values, 0.0, 1.0)


def _color(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    return np.clip(values, 0.0, MAX_COLOR)


def _level(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    return np.clip(np.repeat(0.08 * np.maximum(values, 0.0)[..., None], 3, axis=-1), 0.0, 1.0)


def _albedo(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """As `omni_pbr` for a material without a texture."""
    brightness, add, desaturation, tint = constants[:, :1], constants[:, 1:2], constants[:, 2:3], constants[:, 3:]
    color = values
    if desaturation.any():
        red, green, blue = LUMINANCE.tolist()
        gray = (red * values[..., 0] + green * values[..., 1] + blue * values[..., 2])[..., None]
        color = values + desaturation * (gray - values)
    if (brightness != 1.0).any() or add.any() or (tint != 1.0).any():
        color = (color * brightness + add) * tint
    return np.clip(color, 0.0, MAX_COLOR)


def _albedo_constants(network: Network, shader: UsdShade.Shader) -> tuple[float, ...]:
    numbers = (("albedo_brightness", 1.0), ("albedo_add", 0.0), ("albedo_desaturation", 0.0))
    tint = network.floats(shader, "diffuse_tint", WHITE)
    return (*(network.number(shader, name, default) for name, default in numbers), *tint)


_OMNI_PBR = {
    "diffuse_color_constant": Rule("base_color", _albedo, _albedo_constants),
    "reflection_roughness_constant": Rule("roughness", _unit),
    "metallic_constant": Rule("metallic", _unit),
    "specular_level": Rule("specular", _level),
}
_PREVIEW_SURFACE = {
    "diffuseColor": Rule("base_color", _color),
    "roughness": Rule("roughness", _unit),
    "metallic": Rule("metallic", _unit),
}
_RULES = {
    "UsdPreviewSurface": _PREVIEW_SURFACE,
    **dict.fromkeys(("OmniPBR", "OmniPBR_Opacity", "OmniPBR_ClearCoat", "OmniPBR_ClearCoat_Opacity"), _OMNI_PBR),
}
# Of a displayColor.
DISPLAY_COLOR = Rule("base_color", _color)


def rule_of(
    stage: Usd.Stage, material: Sdf.Path, shader: Sdf.Path, attribute: str
) -> tuple[Rule, tuple[float, ...]] | None:
    """Return the rule for an input of a shader of a material, and its constants; None where it is not read.

    Raises:
        Unsupported: it cannot have other values in each world, or its shader is of another kind.
    """
    surface, network = UsdShade.Shader(stage.GetPrimAtPath(shader)), Network(stage.GetPrimAtPath(material))
    output = UsdShade.Material(network.material).GetSurfaceOutput("mdl")
    connected = output.GetValueProducingAttributes() if output else []
    if connected and connected[0].GetPrimPath() != shader:
        return None  # for viewers without MDL
    name = mdl_name(surface) or shader_id(surface)
    if name == "UsdPreviewSurface" and network.number(surface, "useSpecularWorkflow", 0.0):
        name = "UsdPreviewSurface with useSpecularWorkflow"
    rules = _RULES.get(name, {})
    rule = rules.get(attribute.removeprefix("inputs:"))
    if rule is None:
        raise Unsupported(
            f"{shader}: {attribute} of {name or 'its shader'} cannot differ between worlds; these can: "
            f"{', '.join(rules) or 'none'}"
        )
    return rule, rule.constants(network, surface)
