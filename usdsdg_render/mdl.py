"""Omniverse's own MDL materials, approximated by name and inputs: no MDL compiler here.

Defaults and meanings as in the material templates of the Omniverse documentation (OmniPBR, OmniGlass, OmniSurface).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from pxr import Sdf, UsdShade

from .preview_surface import reflectance, texture_file
from .scene import WRAP_REPEAT
from .shading import Input, Material, Network, UvTransform
from .textures import TextureUse

WHITE = (1.0, 1.0, 1.0)


def mdl_name(shader: UsdShade.Shader) -> str:
    """Name of the MDL material of a shader, "" if it is not MDL."""
    prim = shader.GetPrim()
    asset = prim.GetAttribute("info:mdl:sourceAsset").Get() if prim.HasAttribute("info:mdl:sourceAsset") else None
    identifier = prim.GetAttribute("info:mdl:sourceAsset:subIdentifier")
    name = str(identifier.Get() or "") if identifier else ""
    if not name and isinstance(asset, Sdf.AssetPath):
        name = asset.path.rsplit("/", 1)[-1].removesuffix(".mdl")
    return name.split("(", 1)[0].rsplit("::", 1)[-1] if asset is not None or name else ""


def read_mdl(network: Network, shader: UsdShade.Shader, name: str) -> Material | None:
    """The material if `name`, its MDL name, is one we know, else None."""
    reader = _READERS.get(name)
    if reader is None:
        return None
    material = replace(reader(network, shader), name=str(network.material.GetPath()))
    _warn_of_connections(network, shader)
    return replace(material, uv=_uv(network, shader))


def _warn_of_connections(network: Network, shader: UsdShade.Shader) -> None:
    for name in network.connected(shader):
        network.warn(
            shader,
            f"a shader is connected to inputs:{name}; MDL graphs are not evaluated and its default is used. Author a "
            f"value or a texture file.",
        )


def _uv(network: Network, shader: UsdShade.Shader) -> UvTransform:
    if network.flag(shader, "project_uvw", False):
        network.warn(
            shader, "project_uvw is approximated by the mesh's texture coordinates. Author them, or switch it off."
        )
    return UvTransform(
        scale=network.floats(shader, "texture_scale", (1.0, 1.0)),
        rotation=math.radians(network.number(shader, "texture_rotate", 0.0)),
        translation=network.floats(shader, "texture_translate", (0.0, 0.0)),
    )


def _texture(network: Network, shader: UsdShade.Shader, name: str, *, colour: bool, **baked) -> TextureUse | None:
    file = texture_file(network, shader, name)
    if not file:
        return None
    attribute = network.source(shader, name).attribute
    space = str(attribute.GetColorSpace() or "auto") if attribute is not None else "auto"
    if space not in ("sRGB", "raw"):
        space = "sRGB" if colour else "raw"
    return TextureUse(file, space, colour, WRAP_REPEAT, WRAP_REPEAT, shader=str(shader.GetPath()), **baked)


def _omni_pbr(network: Network, shader: UsdShade.Shader, *, opacity_enabled: bool = False) -> Material:
    orm = _texture(network, shader, "ORM_texture", colour=False)
    if not network.flag(shader, "enable_ORM_texture", False):
        orm = None
    threshold = network.number(shader, "opacity_threshold", 0.0)
    opacity = _opacity(network, shader, enabled=opacity_enabled)
    return Material(
        base_color=_albedo(network, shader),
        roughness=_blended(network, shader, "reflection_roughness", "reflectionroughness_texture", 0.5, orm, 1),
        metallic=_blended(network, shader, "metallic", "metallic_texture", 0.0, orm, 2),
        specular=Input((0.08 * max(network.number(shader, "specular_level", 0.5), 0.0),) * 3),
        opacity=opacity,
        opacity_threshold=max(threshold, 0.0) if opacity != Input((1.0,)) else 0.0,
        emission=_emission(network, shader),
        normal=_texture(network, shader, "normalmap_texture", colour=False),
        normal_scale=network.number(shader, "bump_factor", 1.0),
    )


def _albedo(network: Network, shader: UsdShade.Shader) -> Input:
    """(base desaturated * brightness + add) * tint, where base is the texture, or the constant without one."""
    constant = network.floats(shader, "diffuse_color_constant", (0.2, 0.2, 0.2))
    tint = network.floats(shader, "diffuse_tint", WHITE)
    brightness = network.number(shader, "albedo_brightness", 1.0)
    add = network.number(shader, "albedo_add", 0.0)
    desaturation = network.number(shader, "albedo_desaturation", 0.0)
    grey = 0.2126 * constant[0] + 0.7152 * constant[1] + 0.0722 * constant[2]
    plain = tuple(max(((c + desaturation * (grey - c)) * brightness + add) * t, 0.0) for c, t in zip(constant, tint))
    baked = {}
    factor = tuple(brightness * t for t in tint)
    if add or desaturation:
        baked = {"scale": (brightness,) * 3 + (1.0,), "bias": (add,) * 3 + (0.0,), "desaturation": desaturation}
        factor = tint
    texture = _texture(network, shader, "diffuse_texture", colour=True, **baked)
    return Input(plain) if texture is None else Input(factor, texture, 0, plain)


def _blended(
    network: Network, shader: UsdShade.Shader, name: str, texture_name: str, default: float, orm, orm_channel: int
) -> Input:
    """lerp(constant, texture, influence). MDL's default influence is 0; a texture authored without one counts in full,
    since that is what its author meant."""
    constant = network.number(shader, f"{name}_constant", default)
    influence = min(max(network.number(shader, f"{name}_texture_influence", 1.0), 0.0), 1.0)
    texture, channel = orm, orm_channel
    if texture is None:
        texture, channel = _texture(network, shader, texture_name, colour=False), 0
    if texture is None or influence == 0.0:
        return Input((constant,))
    if influence < 1.0:
        offset = constant * (1.0 - influence)
        texture = replace(texture, scale=(influence,) * 4, bias=(offset,) * 4)
    return Input((1.0,), texture, channel, (constant,))


def _opacity(network: Network, shader: UsdShade.Shader, *, enabled: bool) -> Input:
    if not network.flag(shader, "enable_opacity", enabled):
        return Input((1.0,))
    constant = network.number(shader, "opacity_constant", 1.0)
    texture = None
    if network.flag(shader, "enable_opacity_texture", True):
        texture = _texture(network, shader, "opacity_texture", colour=False)
    from_alpha = network.number(shader, "opacity_mode", 1.0) == 0.0
    return Input((constant,), texture, 3 if from_alpha else 0, (constant,))


def _emission(network: Network, shader: UsdShade.Shader) -> Input:
    """emissive_color * emissive_intensity [nits], tinted by its texture."""
    if not network.flag(shader, "enable_emission", False):
        return Input((0.0, 0.0, 0.0))
    colour = network.floats(shader, "emissive_color", (1.0, 0.1, 0.1))
    intensity = max(network.number(shader, "emissive_intensity", 40.0), 0.0)
    value = tuple(intensity * c for c in colour)
    return Input(value, _texture(network, shader, "emissive_color_texture", colour=True), 0, value)


def _omni_pbr_clearcoat(network: Network, shader: UsdShade.Shader) -> Material:
    coated = network.flag(shader, "enable_clearcoat", True)
    return replace(
        _omni_pbr(network, shader),
        clearcoat=Input((network.number(shader, "clearcoat_weight", 1.0) if coated else 0.0,)),
        clearcoat_roughness=Input((network.number(shader, "clearcoat_reflection_roughness", 0.0),)),
    )


def _omni_glass(network: Network, shader: UsdShade.Shader) -> Material:
    colour = network.floats(shader, "glass_color", WHITE)
    texture = _texture(network, shader, "glass_color_texture", colour=True)
    ior = network.number(shader, "glass_ior", 1.491)
    return Material(
        base_color=Input(colour) if texture is None else Input(WHITE, texture, 0, colour),
        roughness=Input((network.number(shader, "frosting_roughness", 0.0),)),
        specular=Input((reflectance(ior),) * 3),
        transmission=1.0,
        ior=ior,
        thin=network.flag(shader, "thin_walled", False),
        normal=_texture(network, shader, "normal_map_texture", colour=False),
    )


def _omni_surface(network: Network, shader: UsdShade.Shader) -> Material:
    weight = network.number(shader, "diffuse_reflection_weight", 0.8)
    colour = network.floats(shader, "diffuse_reflection_color", WHITE)
    plain = tuple(weight * c for c in colour)
    texture = _texture(network, shader, "diffuse_reflection_color_image", colour=True)
    emission = network.number(shader, "emission_weight", 0.0) * network.number(shader, "emission_intensity", 1.0)
    return Material(
        base_color=Input(plain) if texture is None else Input((weight,) * 3, texture, 0, plain),
        metallic=Input((network.number(shader, "metalness", 0.0),)),
        roughness=Input((network.number(shader, "specular_reflection_roughness", 0.2),)),
        specular=Input((reflectance(network.number(shader, "specular_reflection_ior", 1.5)),) * 3),
        opacity=Input((network.number(shader, "geometry_opacity", 1.0),)),
        emission=Input(tuple(emission * c for c in network.floats(shader, "emission_color", WHITE))),
        normal=_texture(network, shader, "geometry_normal_image", colour=False),
        clearcoat=Input((network.number(shader, "coat_weight", 0.0),)),
        clearcoat_roughness=Input((network.number(shader, "coat_roughness", 0.0),)),
    )


_READERS = {
    "OmniPBR": _omni_pbr,
    "OmniPBR_Opacity": partial(_omni_pbr, opacity_enabled=True),
    "OmniPBR_ClearCoat": _omni_pbr_clearcoat,
    "OmniPBR_ClearCoat_Opacity": _omni_pbr_clearcoat,
    "OmniGlass": _omni_glass,
    "OmniGlass_Opacity": _omni_glass,
    "OmniSurface": _omni_surface,
    "OmniSurfaceBase": _omni_surface,
    "OmniSurfaceLite": _omni_surface,
    "OmniSurfaceLiteBase": _omni_surface,
}
