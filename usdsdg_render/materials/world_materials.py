"""Columns of `scene.MATERIAL` from inputs of shaders that have other values in each of many worlds."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdShade

from usdsdg.errors import Unsupported
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.materials.mdl import mdl_name
from usdsdg_render.materials.mdl_inputs import WHITE
from usdsdg_render.materials.network import Network, shader_id
from usdsdg_render.materials.shading import MAX_COLOR
from usdsdg_render.scene.scene import NO_TEXTURE

# A column, and from the network, the shader and an input's values (worlds, ...) those of the column.
Rule = tuple[str, Callable[[Network, UsdShade.Shader, np.ndarray], np.ndarray]]


def _unit(network: Network, shader: UsdShade.Shader, values: np.ndarray) -> np.ndarray:
    return np.clip(values, 0.0, 1.0)


def _albedo(network: Network, shader: UsdShade.Shader, values: np.ndarray) -> np.ndarray:
    """As `omni_pbr` for a material without a texture."""
    tint = np.array(network.floats(shader, "diffuse_tint", WHITE))
    brightness, add = network.number(shader, "albedo_brightness", 1.0), network.number(shader, "albedo_add", 0.0)
    desaturation = network.number(shader, "albedo_desaturation", 0.0)
    red, green, blue = LUMINANCE.tolist()
    gray = (red * values[:, 0] + green * values[:, 1] + blue * values[:, 2])[:, None]
    color = np.maximum(((values + desaturation * (gray - values)) * brightness + add) * tint, 0.0)
    return np.minimum(color, MAX_COLOR)


def _color(network: Network, shader: UsdShade.Shader, values: np.ndarray) -> np.ndarray:
    return np.clip(values, 0.0, MAX_COLOR)


def _level(network: Network, shader: UsdShade.Shader, values: np.ndarray) -> np.ndarray:
    return np.clip(np.repeat(0.08 * np.maximum(values, 0.0)[:, None], 3, axis=1), 0.0, 1.0)


# Of a column between 32 bits and 64.
_ROUNDING = 1e-4
_OMNI_PBR: dict[str, Rule] = {
    "diffuse_color_constant": ("base_color", _albedo),
    "reflection_roughness_constant": ("roughness", _unit),
    "metallic_constant": ("metallic", _unit),
    "specular_level": ("specular", _level),
}
_PREVIEW_SURFACE: dict[str, Rule] = {
    "diffuseColor": ("base_color", _color),
    "roughness": ("roughness", _unit),
    "metallic": ("metallic", _unit),
}
_RULES = {
    "UsdPreviewSurface": _PREVIEW_SURFACE,
    **dict.fromkeys(("OmniPBR", "OmniPBR_Opacity", "OmniPBR_ClearCoat", "OmniPBR_ClearCoat_Opacity"), _OMNI_PBR),
}


class _Surface(NamedTuple):
    """What a shader's inputs are converted with; the rest of its network is the same in all worlds."""

    shader: UsdShade.Shader
    network: Network
    name: str  # of its kind
    is_read: bool  # False: another shader is the surface of the material


class WorldMaterials:
    """Converts inputs of shaders, and remembers what it has read of their networks."""

    def __init__(self) -> None:
        self._surfaces: dict[Sdf.Path, _Surface] = {}

    def columns(
        self, stage: Usd.Stage, material: Sdf.Path, shader: Sdf.Path, values: dict[str, np.ndarray], row: np.ndarray
    ) -> dict[str, np.ndarray]:
        """Return the columns (worlds, ...) of a material that follow from values of inputs of one of its shaders.

        Args:
            values: (worlds, ...) by name of the attribute.
            row: of the material, as the stage has it.

        Raises:
            Unsupported: an input cannot have other values in each world, or its shader is of another kind.
        """
        known = self._surfaces.get(shader)
        if known is not None:
            columns = _columns(known, values, row)
            # What else the columns depend on has changed where they disagree with what the stage shows in world 0.
            if all(np.abs(column[0] - row[name]).max() < _ROUNDING for name, column in columns.items()):
                return columns
        surface = self._surfaces[shader] = _read(stage, material, shader)
        return _columns(surface, values, row)


def _columns(surface: _Surface, values: dict[str, np.ndarray], row: np.ndarray) -> dict[str, np.ndarray]:
    if not surface.is_read:
        return {}
    shader, rules, columns = surface.shader.GetPath(), _RULES.get(surface.name, {}), {}
    for attribute, column in values.items():
        rule = rules.get(attribute.removeprefix("inputs:"))
        if rule is None:
            raise Unsupported(
                f"{shader}: {attribute} of {surface.name or 'its shader'} cannot differ between worlds; these can: "
                f"{', '.join(rules) or 'none'}"
            )
        field, convert = rule
        if row[f"{field}_texture"] != NO_TEXTURE:
            raise Unsupported(f"{shader}: {attribute} cannot differ between worlds, since a texture is read")
        columns[field] = convert(surface.network, surface.shader, np.asarray(column, np.float64))
    return columns


def _read(stage: Usd.Stage, material: Sdf.Path, path: Sdf.Path) -> _Surface:
    shader, network = UsdShade.Shader(stage.GetPrimAtPath(path)), Network(stage.GetPrimAtPath(material))
    output = UsdShade.Material(network.material).GetSurfaceOutput("mdl")
    connected = output.GetValueProducingAttributes() if output else []
    # A UsdPreviewSurface beside MDL is for other viewers.
    is_read = not connected or connected[0].GetPrimPath() == path
    name = mdl_name(shader) or shader_id(shader)
    if name == "UsdPreviewSurface" and network.number(shader, "useSpecularWorkflow", 0.0):
        name = "UsdPreviewSurface with useSpecularWorkflow"
    return _Surface(shader, network, name, is_read)
