"""Shapes: gprims with sizes and a color."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdGeom

from usdsdg.compat.isaacsim.core.experimental.objects.typed_prims import ColoredPrims

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class Shape(ColoredPrims):
    """Gprims of one type; a new size or axis updates their extents."""

    _schema = UsdGeom.Gprim

    @classmethod
    def _kinds(cls) -> tuple[type[Shape], ...]:
        return (Capsule, Cone, Cube, Cylinder, Plane, Sphere) if cls is Shape else (cls,)

    def _set_number(self, name: str, values: Values, indices: Indices, *, kind: type = float) -> None:
        super()._set_number(name, values, indices, kind=kind)
        self.update_extents(self._schemas(indices))

    def _set_axes(self, axes: str | Sequence[str], indices: Indices) -> None:
        wrong = set([axes] if isinstance(axes, str) else axes) - {"X", "Y", "Z"}
        if wrong:
            raise AssertionError(f"axes are 'X', 'Y' or 'Z', not {sorted(wrong)}")
        self._set_text("Axis", axes, indices)
        self.update_extents(self._schemas(indices))


class Cube(Shape):
    """Cubes; new ones have edges of 2."""

    _schema = UsdGeom.Cube

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        sizes: Values | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if sizes is not None:
            self.set_sizes(sizes)

    def set_sizes(self, sizes: Values, *, indices: Indices = None) -> None:
        """Set the edge lengths (N, 1)."""
        self._set_number("Size", sizes, indices)

    def get_sizes(self, *, indices: Indices = None) -> wp.array:
        """Return the edge lengths (N, 1)."""
        return self._number("Size", indices)


class Sphere(Shape):
    """Spheres; new ones have a radius of 1."""

    _schema = UsdGeom.Sphere

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if radii is not None:
            self.set_radii(radii)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)


class Cylinder(Shape):
    """Cylinders; new ones have a radius of 1 and a height of 2 along Z."""

    _schema = UsdGeom.Cylinder

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        heights: Values | None = None,
        axes: str | Sequence[str] | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if radii is not None:
            self.set_radii(radii)
        if heights is not None:
            self.set_heights(heights)
        if axes is not None:
            self.set_axes(axes)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)

    def set_heights(self, heights: Values, *, indices: Indices = None) -> None:
        """Set the heights along the axis (N, 1)."""
        self._set_number("Height", heights, indices)

    def get_heights(self, *, indices: Indices = None) -> wp.array:
        """Return the heights along the axis (N, 1)."""
        return self._number("Height", indices)

    def set_axes(self, axes: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the axes, "X", "Y" or "Z"."""
        self._set_axes(axes, indices)

    def get_axes(self, *, indices: Indices = None) -> list[str]:
        """Return the axes, "X", "Y" or "Z"."""
        return [str(each.GetAxisAttr().Get()) for each in self._schemas(indices)]


class Cone(Shape):
    """Cones; new ones have a radius of 1 and a height of 2 along Z."""

    _schema = UsdGeom.Cone

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        heights: Values | None = None,
        axes: str | Sequence[str] | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if radii is not None:
            self.set_radii(radii)
        if heights is not None:
            self.set_heights(heights)
        if axes is not None:
            self.set_axes(axes)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)

    def set_heights(self, heights: Values, *, indices: Indices = None) -> None:
        """Set the heights along the axis (N, 1)."""
        self._set_number("Height", heights, indices)

    def get_heights(self, *, indices: Indices = None) -> wp.array:
        """Return the heights along the axis (N, 1)."""
        return self._number("Height", indices)

    def set_axes(self, axes: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the axes, "X", "Y" or "Z"."""
        self._set_axes(axes, indices)

    def get_axes(self, *, indices: Indices = None) -> list[str]:
        """Return the axes, "X", "Y" or "Z"."""
        return [str(each.GetAxisAttr().Get()) for each in self._schemas(indices)]


class Capsule(Shape):
    """Capsules; new ones have a radius of 0.5 and a height of 1, without caps, along Z."""

    _schema = UsdGeom.Capsule

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        heights: Values | None = None,
        axes: str | Sequence[str] | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if radii is not None:
            self.set_radii(radii)
        if heights is not None:
            self.set_heights(heights)
        if axes is not None:
            self.set_axes(axes)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)

    def set_heights(self, heights: Values, *, indices: Indices = None) -> None:
        """Set the heights along the axis (N, 1)."""
        self._set_number("Height", heights, indices)

    def get_heights(self, *, indices: Indices = None) -> wp.array:
        """Return the heights along the axis (N, 1)."""
        return self._number("Height", indices)

    def set_axes(self, axes: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the axes, "X", "Y" or "Z"."""
        self._set_axes(axes, indices)

    def get_axes(self, *, indices: Indices = None) -> list[str]:
        """Return the axes, "X", "Y" or "Z"."""
        return [str(each.GetAxisAttr().Get()) for each in self._schemas(indices)]


class Plane(Shape):
    """Rectangles; new ones have edges of 2 and face along Z."""

    _schema = UsdGeom.Plane

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        widths: Values | None = None,
        lengths: Values | None = None,
        axes: str | Sequence[str] | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)
        if widths is not None:
            self.set_widths(widths)
        if lengths is not None:
            self.set_lengths(lengths)
        if axes is not None:
            self.set_axes(axes)

    def set_widths(self, widths: Values, *, indices: Indices = None) -> None:
        """Set the sizes along x (N, 1)."""
        self._set_number("Width", widths, indices)

    def get_widths(self, *, indices: Indices = None) -> wp.array:
        """Return the sizes along x (N, 1)."""
        return self._number("Width", indices)

    def set_lengths(self, lengths: Values, *, indices: Indices = None) -> None:
        """Set the sizes along y (N, 1)."""
        self._set_number("Length", lengths, indices)

    def get_lengths(self, *, indices: Indices = None) -> wp.array:
        """Return the sizes along y (N, 1)."""
        return self._number("Length", indices)

    def set_axes(self, axes: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the axes, "X", "Y" or "Z"."""
        self._set_axes(axes, indices)

    def get_axes(self, *, indices: Indices = None) -> list[str]:
        """Return the axes, "X", "Y" or "Z"."""
        return [str(each.GetAxisAttr().Get()) for each in self._schemas(indices)]
