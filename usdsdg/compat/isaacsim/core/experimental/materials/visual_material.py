"""`VisualMaterial`: the base of materials for cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pxr import Sdf, Usd, UsdShade

from usdsdg.compat.isaacsim.core.experimental.materials.material import Material
from usdsdg.compat.wrappers import prim_paths, shaders
from usdsdg.compat.wrappers.arrays import as_numpy, as_warp, names, rows
from usdsdg.errors import warn_once

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

PrimOrPath = str | Usd.Prim
# Inputs that are fractions, in any of the materials.
_FRACTIONS = (
    "color", "tint", "roughness", "metallic", "opacity", "influence", "clearcoat", "ao_to_diffuse", "threshold",
)  # fmt: skip


class VisualMaterial(Material):
    """Materials of one kind, with the inputs of their shaders."""

    _noun = ""
    _inputs: ClassVar[Mapping[str, Sdf.ValueTypeName]] = {}

    @property
    def shaders(self) -> list[UsdShade.Shader]:
        return [self._shader(prim) for prim in self.prims]

    def set_input_values(self, name: str, values: str | Sequence[str] | Values, *, indices: Indices = None) -> None:
        """Set an input of the shaders: (N, 1), (N, 2), (N, 3), or texts for textures; one serves for all.

        Fractions are clipped to 0 and 1, with a warning.

        Raises:
            AssetNotFound: a texture does not exist.
            ValueError: the materials have no such input.
        """
        kind = self._kind_of_input(name)
        prims = self._chosen(indices)
        for prim, value in zip(prims, _values(name, kind, values, len(prims)), strict=True):
            self._set(prim, name, kind, value)

    def get_input_values(self, name: str, *, indices: Indices = None) -> list[str] | wp.array:
        """Return an input of the shaders: (N, 1), (N, 2) or (N, 3), or texts for textures.

        Raises:
            RuntimeError: the input has no value.
            ValueError: the materials have no such input.
        """
        kind = self._kind_of_input(name)
        found = [self._shader(prim).GetInput(name) for prim in self._chosen(indices)]
        values = [each.Get() if each else None for each in found]
        if any(value is None for value in values):
            raise RuntimeError(f"{name} of {self.paths} has no value")
        if kind == Sdf.ValueTypeNames.Asset:
            return [value.path for value in values if value is not None]
        dtype = {bool: bool, int: np.int32}.get(type(values[0]), np.float32)
        return self._warp(np.array(values, dtype).reshape(len(values), -1))

    @classmethod
    def are_of_type(cls, paths: PrimOrPath | Sequence[PrimOrPath]) -> wp.array:
        """Return which prims are materials of this kind (N, 1)."""
        return as_warp(np.array([[cls._is_kind(prim_paths.prim_of(each))] for each in _listed(paths)], bool))

    @staticmethod
    def fetch_instances(paths: PrimOrPath | Sequence[PrimOrPath]) -> list[VisualMaterial | None]:
        """Return a wrapper of each material, of the class for its kind; None for other prims."""
        kinds = VisualMaterial.__subclasses__()
        found: list[VisualMaterial | None] = []
        for each in _listed(paths):
            prim = prim_paths.prim_of(each)
            kind = next((kind for kind in kinds if kind._is_kind(prim)), None)
            found.append(kind(str(prim.GetPath())) if kind else None)
        return found

    def _kind_of_input(self, name: str) -> Sdf.ValueTypeName:
        if name not in self._inputs:
            raise ValueError(f"{type(self).__name__} has no input {name!r}; it has {', '.join(sorted(self._inputs))}")
        return self._inputs[name]

    @classmethod
    def _define(cls, path: str) -> None:
        raise NotImplementedError

    @classmethod
    def _is_kind(cls, prim: Usd.Prim) -> bool:
        raise NotImplementedError

    def _shader(self, prim: Usd.Prim) -> UsdShade.Shader:
        return shaders.surface_shader(prim)

    def _set(self, prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: Any) -> None:
        shaders.set_input(prim, name, kind, value)


def _values(name: str, kind: Sdf.ValueTypeName, values: Any, count: int) -> list[Any]:
    """Return a Python value per prim."""
    if kind == Sdf.ValueTypeNames.Asset:
        return names(values, count)
    size = getattr(type(kind.defaultValue), "dimension", 1)
    numbers = rows(as_numpy(values), size, count)
    if any(part in name.lower() for part in _FRACTIONS) and kind.scalarType in _REALS:
        clipped = np.clip(numbers, 0.0, 1.0)
        if (clipped != numbers).any():
            warn_once(f"{name}: values outside 0 and 1 are clipped")
        numbers = clipped
    return numbers[:, 0].tolist() if size == 1 else [tuple(row) for row in numbers.tolist()]


_REALS = (Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.Float3)


def _listed(paths: PrimOrPath | Sequence[PrimOrPath]) -> list[PrimOrPath]:
    return list(paths) if isinstance(paths, (list, tuple)) else [paths]  # pyright: ignore[reportReturnType]
