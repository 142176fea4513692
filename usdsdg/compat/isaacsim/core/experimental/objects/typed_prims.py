"""The base of objects: prims of one USD type, which are defined where they do not exist."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.experimental.prims import XformPrim
from usdsdg.compat.wrappers import prim_paths
from usdsdg.compat.wrappers.arrays import as_warp, column, names, rows
from usdsdg.compat.wrappers.colors import rgb_rows

if TYPE_CHECKING:
    from typing import Self

    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

PrimOrPath = str | Usd.Prim


class TypedPrims(XformPrim):
    """Prims of the type `_schema`; lengths are stage units."""

    _schema: ClassVar[Any]

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        define: Callable[[str], object] | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap the prims at these paths, or define them; `define` does so with one path.

        Raises:
            AssertionError: a prim is of another type.
            ValueError: some prims exist and others do not.
        """
        existing, missing = self.resolve_paths(paths)
        for path in missing:
            (define or self._define)(path)
        for path in existing:
            prim = prim_paths.prim_of(path)
            if not prim.IsA(self._schema):
                kind = prim.GetTypeName() or "prim without a type"
                raise AssertionError(f"{path} is a {kind}, not a {self._schema.__name__}")
        super().__init__(
            existing or missing, resolve_paths=False, positions=positions, translations=translations,
            orientations=orientations, scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip

    @classmethod
    def are_of_type(cls, paths: PrimOrPath | Sequence[PrimOrPath]) -> wp.array:
        """Return which prims are of this type (N,)."""
        return as_warp(np.array([prim_paths.prim_of(each).IsA(cls._schema) for each in _listed(paths)], bool))

    @classmethod
    def fetch_instances(cls, paths: PrimOrPath | Sequence[PrimOrPath]) -> list[Self | None]:
        """Return a wrapper of each prim, of the class for its type; None for other prims."""
        found: list[Self | None] = []
        for each in _listed(paths):
            prim = prim_paths.prim_of(each)
            kind = next((kind for kind in cls._kinds() if prim.IsA(kind._schema)), None)
            found.append(kind(str(prim.GetPath()), reset_xform_op_properties=False) if kind else None)
        return found

    @classmethod
    def _kinds(cls) -> tuple[type[Self], ...]:
        """Return the classes of prims of these types."""
        return (cls,)

    @classmethod
    def _define(cls, path: str) -> object:
        return cls._schema.Define(used_stage.current_stage(), path)

    def _schemas(self, indices: Indices = None) -> list[Any]:
        return [self._schema(prim) for prim in self._chosen(indices)]

    def _number(self, name: str, indices: Indices) -> wp.array:
        """Return the attribute of `Get<name>Attr` (N, 1)."""
        values = [getattr(each, f"Get{name}Attr")().Get() for each in self._schemas(indices)]
        dtype = bool if values and isinstance(values[0], bool) else np.float32
        return self._warp(np.array(values, dtype).reshape(-1, 1))

    def _set_number(self, name: str, values: Values, indices: Indices, *, kind: type = float) -> None:
        schemas = self._schemas(indices)
        for each, value in zip(schemas, column(values, len(schemas)), strict=True):
            getattr(each, f"Create{name}Attr")().Set(kind(value))

    def _set_text(self, name: str, values: str | Sequence[str], indices: Indices) -> None:
        schemas = self._schemas(indices)
        for each, value in zip(schemas, names(values, len(schemas)), strict=True):
            getattr(each, f"Create{name}Attr")().Set(value)

    def _set_vector(self, name: str, values: Values, indices: Indices) -> None:
        schemas = self._schemas(indices)
        for each, value in zip(schemas, rows(values, 3, len(schemas)), strict=True):
            getattr(each, f"Create{name}Attr")().Set(Gf.Vec3f(*value.tolist()))


class ColoredPrims(TypedPrims):
    """Gprims, which have a color."""

    @property
    def geoms(self) -> list[Any]:
        """Return each prim as its schema."""
        return self._schemas()

    def set_display_colors(
        self, colors: str | Sequence[str] | Sequence[float] | np.ndarray, *, indices: Indices = None
    ) -> None:
        """Set the color of prims without a material (N, 3), or by name."""
        schemas = self._schemas(indices)
        for each, color in zip(schemas, rgb_rows(colors, len(schemas)), strict=True):
            each.CreateDisplayColorAttr().Set([Gf.Vec3f(*color.tolist())])

    @staticmethod
    def update_extents(geoms: Sequence[UsdGeom.Boundable]) -> None:
        """Author the extents that follow from sizes or points."""
        for geom in geoms:
            extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(geom), Usd.TimeCode.Default())
            if extent:
                UsdGeom.Boundable(geom).CreateExtentAttr().Set(extent)


def _listed(paths: PrimOrPath | Sequence[PrimOrPath]) -> list[PrimOrPath]:
    return list(paths) if isinstance(paths, (list, tuple)) else [paths]  # pyright: ignore[reportReturnType]
