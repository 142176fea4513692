"""`isaacsim.core.experimental.materials`: visual, other and physics materials, each one or more prims."""

from usdsdg.compat.isaacsim.core.experimental.materials.non_visual_material import NonVisualMaterial
from usdsdg.compat.isaacsim.core.experimental.materials.omni_glass import OmniGlassMaterial
from usdsdg.compat.isaacsim.core.experimental.materials.omni_pbr import OmniPbrMaterial
from usdsdg.compat.isaacsim.core.experimental.materials.physics_material import PhysicsMaterial, RigidBodyMaterial
from usdsdg.compat.isaacsim.core.experimental.materials.preview_surface import PreviewSurfaceMaterial
from usdsdg.compat.isaacsim.core.experimental.materials.visual_material import VisualMaterial

__all__ = [
    "NonVisualMaterial", "OmniGlassMaterial", "OmniPbrMaterial", "PhysicsMaterial", "PreviewSurfaceMaterial",
    "RigidBodyMaterial", "VisualMaterial",
]  # fmt: skip
