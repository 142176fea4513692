"""Spheres: visual, fixed and dynamic."""

from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.api.objects.shape import DynamicShape, FixedShape, VisualShape


class VisualSphere(VisualShape):
    """A sphere that is seen; radius of a new one is 1."""

    _schema = UsdGeom.Sphere
    _sizes = {"radius": ("Radius", 1.0)}

    def set_radius(self, radius: float) -> None:
        """Set the radius [stage units]."""
        self._set_size("radius", radius)

    def get_radius(self) -> float:
        """Return the radius [stage units]."""
        return self._get_size("radius")


class FixedSphere(VisualSphere, FixedShape):
    """A sphere that collides."""

    _approximation = "boundingSphere"


class DynamicSphere(DynamicShape, FixedSphere):
    """A sphere that collides and falls."""
