"""`Mesh`: meshes, empty or of a shape."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdGeom, Vt

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.experimental.objects.typed_prims import ColoredPrims
from usdsdg.compat.wrappers.arrays import as_numpy, names
from usdsdg.stage.geometry import shape_meshes

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

_SHAPES = ("Cone", "Cube", "Cylinder", "Disk", "Plane", "Sphere", "Torus")


class Mesh(ColoredPrims):
    """Meshes. A shape is one meter in size."""

    _schema = UsdGeom.Mesh

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        primitives: str | Sequence[str] | None = None,
        colors: str | Sequence[str] | Sequence[float] | np.ndarray | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap meshes, or define them; see `XformPrim` for the poses.

        Args:
            primitives: "Cone", "Cube", "Cylinder", "Disk", "Plane", "Sphere" or "Torus"; None for empty meshes.

        Raises:
            AssertionError: there is no such shape.
        """
        given = [paths] if isinstance(paths, str) else list(paths)
        kinds = iter([] if primitives is None else names(primitives, len(given)))
        super().__init__(
            paths, define=partial(_define, kinds), positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if colors is not None:
            self.set_display_colors(colors)

    @property
    def num_faces(self) -> list[int]:
        return [geom.GetFaceCount() for geom in self.geoms]

    def set_points(self, points: Sequence[Values], *, indices: Indices = None) -> None:
        """Set the points of each mesh, (P, 3) [stage units]; the points of one serve for all."""
        self._set_arrays("Points", points, indices, Vt.Vec3fArray, 3)
        self.update_extents(self._schemas(indices))

    def get_points(self, *, indices: Indices = None) -> list[wp.array]:
        """Return the points of each mesh, (P, 3) [stage units]."""
        return self._arrays("Points", indices, np.float32, 3)

    def set_normals(self, normals: Sequence[Values], *, indices: Indices = None) -> None:
        """Set the normals of each mesh, (P, 3)."""
        self._set_arrays("Normals", normals, indices, Vt.Vec3fArray, 3)

    def get_normals(self, *, indices: Indices = None) -> list[wp.array]:
        """Return the normals of each mesh, (P, 3)."""
        return self._arrays("Normals", indices, np.float32, 3)

    def set_face_specs(
        self,
        vertex_indices: Sequence[Values] | None = None,
        vertex_counts: Sequence[Values] | None = None,
        varying_linear_interpolations: str | Sequence[str] | None = None,
        hole_indices: Sequence[Values] | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set the corners, the corners per face and the holes of each mesh; what is not given stays."""
        for name, values in (
            ("FaceVertexIndices", vertex_indices), ("FaceVertexCounts", vertex_counts), ("HoleIndices", hole_indices)
        ):  # fmt: skip
            if values is not None:
                self._set_arrays(name, values, indices, Vt.IntArray, 1)
        if varying_linear_interpolations is not None:
            self._set_text("FaceVaryingLinearInterpolation", varying_linear_interpolations, indices)

    def get_face_specs(
        self, *, indices: Indices = None
    ) -> tuple[list[wp.array], list[wp.array], list[str], list[wp.array]]:
        """Return corners, corners per face, interpolation and holes of each mesh."""
        rules = [str(each.GetFaceVaryingLinearInterpolationAttr().Get()) for each in self._schemas(indices)]
        return (
            self._arrays("FaceVertexIndices", indices, np.int32, 1),
            self._arrays("FaceVertexCounts", indices, np.int32, 1),
            rules,
            self._arrays("HoleIndices", indices, np.int32, 1),
        )

    def set_subdivision_specs(
        self,
        subdivision_schemes: str | Sequence[str] | None = None,
        interpolate_boundaries: str | Sequence[str] | None = None,
        triangle_subdivision_rules: str | Sequence[str] | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set how the meshes are subdivided; what is not given stays."""
        for name, values in (
            ("SubdivisionScheme", subdivision_schemes), ("InterpolateBoundary", interpolate_boundaries),
            ("TriangleSubdivisionRule", triangle_subdivision_rules),
        ):  # fmt: skip
            if values is not None:
                self._set_text(name, values, indices)

    def get_subdivision_specs(self, *, indices: Indices = None) -> tuple[list[str], list[str], list[str]]:
        """Return scheme, boundary and triangle rule of each mesh."""
        meshes = self._schemas(indices)
        return (
            [str(each.GetSubdivisionSchemeAttr().Get()) for each in meshes],
            [str(each.GetInterpolateBoundaryAttr().Get()) for each in meshes],
            [str(each.GetTriangleSubdivisionRuleAttr().Get()) for each in meshes],
        )

    def _set_arrays(self, name: str, values: Sequence[Values], indices: Indices, kind: type, width: int) -> None:
        meshes = self._schemas(indices)
        for index, mesh in enumerate(meshes):
            numbers = as_numpy(values[0 if len(values) == 1 else index])
            dtype = np.float32 if width == 3 else np.int32
            shaped = numbers.reshape((-1, 3) if width == 3 else -1).astype(dtype)
            getattr(mesh, f"Create{name}Attr")().Set(kind.FromNumpy(np.ascontiguousarray(shaped)))  # pyright: ignore[reportAttributeAccessIssue]

    def _arrays(self, name: str, indices: Indices, dtype: type, width: int) -> list[wp.array]:
        values = [getattr(mesh, f"Get{name}Attr")().Get() for mesh in self._schemas(indices)]
        shape = (-1, 3) if width == 3 else -1
        return [self._warp(np.array([] if value is None else value, dtype).reshape(shape)) for value in values]


def _define(kinds: object, path: str) -> UsdGeom.Mesh:
    """Define a mesh of the next shape; an empty one when there is none."""
    stage = used_stage.current_stage()
    kind = next(kinds, None)  # pyright: ignore[reportArgumentType, reportCallIssue]
    if kind is None:
        return UsdGeom.Mesh.Define(stage, path)
    if kind not in _SHAPES:
        raise AssertionError(f"there is no shape {kind!r}; primitives are {', '.join(_SHAPES)}")
    return shape_meshes.define(stage, path, kind)
