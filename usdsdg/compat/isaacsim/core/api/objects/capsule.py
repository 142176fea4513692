"""Capsules: visual, fixed and dynamic."""

from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.api.objects.shape import DynamicShape, FixedShape, VisualShape


class VisualCapsule(VisualShape):
    """A capsule that is seen; radius and height of a new one are 1."""

    _schema = UsdGeom.Capsule
    _sizes = {"radius": ("Radius", 1.0), "height": ("Height", 1.0)}

    def set_radius(self, radius: float) -> None:
        """Set the radius [stage units]."""
        self._set_size("radius", radius)

    def get_radius(self) -> float:
        """Return the radius [stage units]."""
        return self._get_size("radius")

    def set_height(self, height: float) -> None:
        """Set the height along the axis [stage units]."""
        self._set_size("height", height)

    def get_height(self) -> float:
        """Return the height along the axis [stage units]."""
        return self._get_size("height")


class FixedCapsule(VisualCapsule, FixedShape):
    """A capsule that collides."""

    _approximation = "convexHull"


class DynamicCapsule(DynamicShape, FixedCapsule):
    """A capsule that collides and falls."""
