"""Read the OmniPBR family of Omniverse's MDL templates.

Mirrors https://docs.omniverse.nvidia.com/materials-and-rendering/latest/templates/OmniPBR.html
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pxr import Gf, UsdShade, Vt

from usdsdg import errors
from usdsdg.stage.colors import LUMINANCE
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.mdl.inputs import (
    BLACK,
    WHITE,
    blended,
    cutout,
    normal_map,
    number_texture,
    texture,
    textured,
    transform,
    uv_primvar,
    warn_of_projection,
    warn_of_textures,
    warn_where,
)
from usdsdg_render.materials.network import Network
from usdsdg_render.materials.preview_surface import reflectance
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import UvTransform

# A color that is brighter is one in levels of 0 to 255: scripts that mean to exaggerate stay below.
_BRIGHTEST = 2.0

COAT_IOR = 1.56


def read_omni_pbr(network: Network, shader: UsdShade.Shader, *, opacity_enabled: bool = False) -> Material:
    """Read OmniPBR, or OmniPBR_Opacity, where opacity is enabled by default."""
    uv = transform(network, shader)
    warn_of_projection(network, shader)
    orm = None
    if network.flag(shader, "enable_ORM_texture", False):
        orm = texture(network, shader, "ORM_texture", color=False, transform=uv)
    _warn_of_occlusion(network, shader)
    roughness, metallic = ("reflection_roughness", "reflectionroughness_texture"), ("metallic", "metallic_texture")
    detail_uv = transform(network, shader, "detail_texture")
    material = network.read_fields(
        {
            "base_color": lambda: _albedo(network, shader, uv),
            "roughness": lambda: _blended(network, shader, *roughness, 0.5, orm, 1, uv),
            "metallic": lambda: _blended(network, shader, *metallic, 0.0, orm, 2, uv),
            "specular": lambda: Input((0.08 * network.limited(shader, "specular_level", 0.5, math.inf),) * 3),
            "opacity": lambda: _opacity(network, shader, uv, enabled=opacity_enabled),
            "opacity_threshold": lambda: _threshold(network, shader, uv, enabled=opacity_enabled),
            "emission": lambda: _emission(network, shader, uv),
            "normal": lambda: normal_map(network, shader, "normalmap_texture", uv),
            "normal_scale": lambda: network.number(shader, "bump_factor", 1.0),
            "detail": lambda: normal_map(network, shader, "detail_normalmap_texture", detail_uv),
            "detail_scale": lambda: network.number(shader, "detail_bump_factor", 0.3),
        }
    )
    return replace(material, uv_primvar=uv_primvar(network, shader, "uv_space_index"))


def read_omni_pbr_clearcoat(network: Network, shader: UsdShade.Shader, *, opacity_enabled: bool = False) -> Material:
    """Read OmniPBR_ClearCoat."""
    weight = network.number(shader, "clearcoat_weight", 1.0)
    if not network.flag(shader, "enable_clearcoat", True):
        weight = 0.0
    elif weight > 0.0:
        warn_where(network, shader, {"clearcoat_tint": WHITE, "clearcoat_transparency": (1.0,)})
        warn_of_textures(network, shader, ["clearcoat_normalmap_texture"])
    return replace(
        read_omni_pbr(network, shader, opacity_enabled=opacity_enabled),
        coat_f0=reflectance(network.ior(shader, "clearcoat_ior", COAT_IOR)),
        clearcoat=Input((weight,)),
        clearcoat_roughness=Input((network.number(shader, "clearcoat_reflection_roughness", 0.0),)),
    )


def _albedo(network: Network, shader: UsdShade.Shader, uv: UvTransform) -> Input:
    """Read (desaturated base * brightness + add) * tint, where base is the texture, or the constant without one."""
    constant = network.floats(shader, "diffuse_color_constant", (0.2, 0.2, 0.2))
    tint = network.floats(shader, "diffuse_tint", WHITE)
    brightness = network.number(shader, "albedo_brightness", 1.0)
    add = network.number(shader, "albedo_add", 0.0)
    if min(constant) < 0.0:
        network.warn(shader, "inputs:diffuse_color_constant has a negative color, of which 0 is used. Correct it.")
    if max(constant) > _BRIGHTEST:
        errors.warn_once(
            f"{shader.GetPath()}: inputs:diffuse_color_constant is {max(constant):g}, more light than "
            "falls on it is reflected. Colors are 0 to 1: divide levels of 0 to 255 by 255.",
            key="colors that reflect more light than there is",  # one for a thousand prims of a randomizer
        )
    desaturation = network.number(shader, "albedo_desaturation", 0.0)
    red, green, blue = LUMINANCE.tolist()
    gray = red * constant[0] + green * constant[1] + blue * constant[2]
    untextured = tuple(
        max(((c + desaturation * (gray - c)) * brightness + add) * t, 0.0) for c, t in zip(constant, tint)
    )
    use = texture(network, shader, "diffuse_texture", color=True, transform=uv)
    if use is None:
        albedo = Input(untextured)
    elif not add:
        albedo = Input(tuple(brightness * t for t in tint), replace(use, desaturation=desaturation), 0, untextured)
    else:
        use = replace(use, desaturation=desaturation, scale=(brightness,) * 3 + (1.0,), bias=(add,) * 3 + (0.0,))
        albedo = Input(tint, use, 0, untextured)
    if tint == WHITE and (brightness, add, desaturation) == (1.0, 0.0, 0.0):
        network.note_alone(shader, "diffuse_color_constant", _plain_albedos, albedo)
    return albedo


def _plain_albedos(colors: Sequence[Any], before: Sequence[Input]) -> list[Input | None]:
    """Make `_albedo` of constants that nothing else changes, from earlier albedos of the same textures."""
    if any(type(color) is not Gf.Vec3f for color in colors):
        return [None] * len(colors)
    rows = np.array(Vt.Vec3fArray(colors), np.float64)
    # Adding zero makes a positive one of a negative one.
    usable = np.isfinite(rows).all(axis=1).tolist()
    constants = map(tuple, (np.maximum(rows, 0.0) + 0.0).tolist())
    return [
        None if not good else Input(color) if use is None else Input(value, use, 0, color)
        for good, color, value, use in zip(usable, constants, [b.value for b in before], [b.texture for b in before])
    ]


def _blended(
    network: Network,
    shader: UsdShade.Shader,
    name: str,
    texture_name: str,
    default: float,
    orm: TextureUse | None,
    orm_channel: int,
    uv: UvTransform,
) -> Input:
    """Blend a constant with the ORM map's channel or a texture of its own.

    MDL's default influence is 0; here a texture authored without one counts in full, as its author meant.
    """
    constant = network.number(shader, f"{name}_constant", default)
    own = None if orm is not None else number_texture(network, shader, texture_name, transform=uv)
    if orm is None and own is None:
        network.note_alone(shader, f"{name}_constant", _plain_numbers)
    influence = network.number(shader, f"{name}_texture_influence", 1.0)
    if orm is not None:
        return blended(constant, orm, orm_channel, influence)
    return blended(constant, own, 0, influence)


def _plain_numbers(values: Sequence[Any], _: Sequence[Any]) -> list[Input | None]:
    """Make `_blended` of constants where there are no textures."""
    return [Input((value,)) if type(value) is float and math.isfinite(value) else None for value in values]


def _opacity(network: Network, shader: UsdShade.Shader, uv: UvTransform, *, enabled: bool) -> Input:
    if not network.flag(shader, "enable_opacity", enabled):
        return Input((1.0,))
    constant = network.number(shader, "opacity_constant", 1.0)
    if not network.flag(shader, "enable_opacity_texture", True):
        return Input((constant,))
    return cutout(network, shader, "opacity_texture", "opacity_mode", constant, uv)


def _threshold(network: Network, shader: UsdShade.Shader, uv: UvTransform, *, enabled: bool) -> float:
    threshold = max(network.number(shader, "opacity_threshold", 0.0), 0.0)
    return threshold if _opacity(network, shader, uv, enabled=enabled) != Input((1.0,)) else 0.0


def _emission(network: Network, shader: UsdShade.Shader, uv: UvTransform) -> Input:
    """Read emissive_color * emissive_intensity [nits], times its texture or its mask."""
    if not network.flag(shader, "enable_emission", False):
        return Input(BLACK)
    color = network.floats(shader, "emissive_color", (1.0, 0.1, 0.1))
    intensity = max(network.number(shader, "emissive_intensity", 40.0), 0.0)
    value = tuple(intensity * c for c in color)
    use = texture(network, shader, "emissive_color_texture", color=True, transform=uv)
    mask = texture(network, shader, "emissive_mask_texture", color=False, transform=uv)
    if use is not None and mask is not None:
        network.warn(
            shader, "emissive_mask_texture is ignored beside emissive_color_texture. Multiply one into the other."
        )
    return textured(value, use or mask, factor=value)


def _warn_of_occlusion(network: Network, shader: UsdShade.Shader) -> None:
    if network.number(shader, "ao_to_diffuse", 0.0) > 0.0:
        network.warn(shader, "ao_to_diffuse is ignored: rays find what hides the light. Bake it into the albedo map.")
