"""`OmniGlassMaterial`: materials of OmniGlass.mdl."""

from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders


class OmniGlassMaterial(VisualMaterial):
    """OmniGlass: color, index of refraction, roughness, thin walls."""

    _inputs = shaders.OMNI_GLASS_INPUTS

    @classmethod
    def _define(cls, path: str) -> None:
        shaders.define_mdl(path, "OmniGlass.mdl")

    @classmethod
    def _is_kind(cls, prim: Usd.Prim) -> bool:
        return shaders.mdl_name(prim) == "omniglass.mdl"
