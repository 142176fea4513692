"""Gprims with UsdLux's LightAPI (mesh lights): rendered as emissive surfaces and sampled as area lights."""

from dataclasses import replace

from pxr import Usd, UsdLux

from usdsdg import errors
from usdsdg_render.lights.light_inputs import warn_of_ignored
from usdsdg_render.lights.light_values import SHADOW, SHAPING, changed_inputs, emitted_color, light_value
from usdsdg_render.lights.linking import is_linked
from usdsdg_render.materials.shading import Input, Material

BLACK = (0.0, 0.0, 0.0)
# Inputs that a surface does not have, with values that change nothing.
_IGNORED = {"diffuse": 1.0, "specular": 1.0, "shadow:enable": True, **SHADOW, **SHAPING}


def is_light(prim: Usd.Prim) -> bool:
    """Whether a gprim is also a light."""
    return prim.HasAPI(UsdLux.LightAPI)


def emissive_material(material: Material, prim: Usd.Prim) -> Material:
    """Return the emissive material of a mesh light, by its light:materialSyncMode."""
    color = emitted_color(prim)
    warn_of_ignored(prim)
    _warn_of_links_and_shapes(prim)
    emission = BLACK if color is None else tuple(color.tolist())
    if light_value(prim, "normalize", False):
        errors.warn_once(
            f"{prim.GetPath()}: inputs:normalize of a mesh light is not supported and is ignored. Divide its "
            f"intensity by the area."
        )
    mode = prim.GetAttribute("light:materialSyncMode").Get()
    if mode == UsdLux.Tokens.noMaterialResponse:
        dark = Input(BLACK)
        return Material(name=material.name, base_color=dark, specular=dark, emission=Input(emission))
    own_emission = material.emission
    if mode == UsdLux.Tokens.materialGlowTintsLight and (own_emission.texture is not None or any(own_emission.value)):
        tinted = tuple(a * b for a, b in zip(own_emission.value, emission))
        return replace(material, emission=own_emission._replace(value=tinted, fallback=None))
    return replace(material, emission=Input(emission))


def _warn_of_links_and_shapes(prim: Usd.Prim) -> None:
    ignored = [*changed_inputs(prim, _IGNORED), *(["its light and shadow links"] if is_linked(prim) else [])]
    if ignored:
        errors.warn_once(
            f"{prim.GetPath()}: a mesh light shines to all sides, on everything, with shadows; {', '.join(ignored)} "
            f"have no effect. Use a RectLight, a DiskLight or another light of UsdLux."
        )
