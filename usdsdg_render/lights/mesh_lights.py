"""Gprims with UsdLux's LightAPI: drawn as surfaces that emit, and like all of them drawn from (see `emitters`)."""

from __future__ import annotations

from dataclasses import replace

from pxr import Usd, UsdLux

from usdsdg import errors
from usdsdg_render.lights.light_values import emitted_colour, light_value
from usdsdg_render.materials.shading import Input, Material

BLACK = (0.0, 0.0, 0.0)


def is_light(prim: Usd.Prim) -> bool:
    """Whether a gprim is a light too."""
    return prim.HasAPI(UsdLux.LightAPI)


def glowing(material: Material, prim: Usd.Prim) -> Material:
    """The material of a gprim that is a light, by its light:materialSyncMode."""
    colour = emitted_colour(prim)
    emission = BLACK if colour is None else tuple(colour.tolist())
    if light_value(prim, "normalize", False):
        errors.warn_once(
            f"{prim.GetPath()}: inputs:normalize of a mesh light is not supported and is ignored. Divide its "
            f"intensity by the area."
        )
    mode = prim.GetAttribute("light:materialSyncMode").Get()
    if mode == UsdLux.Tokens.noMaterialResponse:
        dark = Input(BLACK)
        return Material(name=material.name, base_color=dark, specular=dark, emission=Input(emission))
    glow = material.emission
    if mode == UsdLux.Tokens.materialGlowTintsLight and (glow.texture is not None or any(glow.value)):
        tinted = tuple(a * b for a, b in zip(glow.value, emission))
        return replace(material, emission=replace(glow, value=tinted, missing=None))
    return replace(material, emission=Input(emission))
