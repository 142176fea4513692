"""`isaacsim.core.api.materials`: visual and physics materials."""

from usdsdg.compat.isaacsim.core.api.materials.omni_glass import OmniGlass
from usdsdg.compat.isaacsim.core.api.materials.omni_pbr import OmniPBR
from usdsdg.compat.isaacsim.core.api.materials.physics_material import PhysicsMaterial
from usdsdg.compat.isaacsim.core.api.materials.preview_surface import PreviewSurface
from usdsdg.compat.isaacsim.core.api.materials.visual_material import VisualMaterial
from usdsdg.compat.wrappers import shaders
from usdsdg.compat.wrappers.prim_paths import prim_of

__all__ = ["OmniGlass", "OmniPBR", "PhysicsMaterial", "PreviewSurface", "VisualMaterial", "material_at"]


def material_at(path: str) -> VisualMaterial | None:
    """Return a wrapper of the material at a path, of the class for its kind; None for other kinds."""
    prim = prim_of(path)
    known = {"omnipbr.mdl": OmniPBR, "omniglass.mdl": OmniGlass}.get(shaders.mdl_name(prim))
    if known is None and shaders.preview_shader(prim):
        known = PreviewSurface
    return known(path) if known else None
