"""Cuboids: visual, fixed and dynamic."""

from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.api.objects.shape import DynamicShape, FixedShape, VisualShape


class VisualCuboid(VisualShape):
    """A cube that is seen; size of a new one is 1."""

    _schema = UsdGeom.Cube
    _sizes = {"size": ("Size", 1.0)}

    def set_size(self, size: float) -> None:
        """Set the edge length [stage units]."""
        self._set_size("size", size)

    def get_size(self) -> float:
        """Return the edge length [stage units]."""
        return self._get_size("size")


class FixedCuboid(VisualCuboid, FixedShape):
    """A cube that collides."""

    _approximation = "boundingCube"


class DynamicCuboid(DynamicShape, FixedCuboid):
    """A cube that collides and falls."""
