"""`isaacsim.core.experimental.objects`: shapes, meshes, lights, cameras and ground planes, each one or more prims."""

from usdsdg.compat.isaacsim.core.experimental.objects.camera import Camera
from usdsdg.compat.isaacsim.core.experimental.objects.ground_plane import GroundPlane
from usdsdg.compat.isaacsim.core.experimental.objects.lights import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    Light,
    RectLight,
    SphereLight,
)
from usdsdg.compat.isaacsim.core.experimental.objects.mesh import Mesh
from usdsdg.compat.isaacsim.core.experimental.objects.shapes import (
    Capsule,
    Cone,
    Cube,
    Cylinder,
    Plane,
    Shape,
    Sphere,
)

__all__ = [
    "Camera", "Capsule", "Cone", "Cube", "Cylinder", "CylinderLight", "DiskLight", "DistantLight", "DomeLight",
    "GroundPlane", "Light", "Mesh", "Plane", "RectLight", "Shape", "Sphere", "SphereLight",
]  # fmt: skip
