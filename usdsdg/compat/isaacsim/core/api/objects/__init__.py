"""`isaacsim.core.api.objects`: visual, fixed and dynamic shapes, and the ground plane."""

from usdsdg.compat.isaacsim.core.api.objects.capsule import DynamicCapsule, FixedCapsule, VisualCapsule
from usdsdg.compat.isaacsim.core.api.objects.cone import DynamicCone, FixedCone, VisualCone
from usdsdg.compat.isaacsim.core.api.objects.cuboid import DynamicCuboid, FixedCuboid, VisualCuboid
from usdsdg.compat.isaacsim.core.api.objects.cylinder import DynamicCylinder, FixedCylinder, VisualCylinder
from usdsdg.compat.isaacsim.core.api.objects.ground_plane import GroundPlane
from usdsdg.compat.isaacsim.core.api.objects.sphere import DynamicSphere, FixedSphere, VisualSphere

__all__ = [
    "DynamicCapsule", "DynamicCone", "DynamicCuboid", "DynamicCylinder", "DynamicSphere", "FixedCapsule", "FixedCone",
    "FixedCuboid", "FixedCylinder", "FixedSphere", "GroundPlane", "VisualCapsule", "VisualCone", "VisualCuboid",
    "VisualCylinder", "VisualSphere",
]  # fmt: skip
