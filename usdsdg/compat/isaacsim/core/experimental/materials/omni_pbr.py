"""`OmniPbrMaterial`: materials of OmniPBR.mdl."""

from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders


class OmniPbrMaterial(VisualMaterial):
    """OmniPBR: color, roughness, metallic, textures, emission."""

    _inputs = shaders.OMNI_PBR_INPUTS

    @classmethod
    def _define(cls, path: str) -> None:
        shaders.define_mdl(path, "OmniPBR.mdl")

    @classmethod
    def _is_kind(cls, prim: Usd.Prim) -> bool:
        return shaders.mdl_name(prim) == "omnipbr.mdl"
