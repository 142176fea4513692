"""`VisualMaterial`: the base of materials for cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from pxr import Sdf, Usd, UsdShade

from usdsdg.compat.wrappers import shaders
from usdsdg.compat.wrappers.arrays import as_numpy
from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import BadPrim


class VisualMaterial:
    """One material, and the inputs of its shader."""

    _inputs: ClassVar[Mapping[str, Sdf.ValueTypeName]] = {}

    def __init__(self, name: str, prim_path: str) -> None:
        """Wrap the material at a path, or define it.

        Raises:
            BadPrim: the prim is no material.
        """
        if not prim_of(prim_path):
            self._define(prim_path)
        prim = prim_of(prim_path)
        if not prim.IsA(UsdShade.Material):
            raise BadPrim(f"{prim_path} is a {prim.GetTypeName() or 'prim without a type'}, not a material")
        self._name, self._prim = name, prim

    @classmethod
    def _define(cls, prim_path: str) -> None:
        raise NotImplementedError

    @property
    def name(self) -> str:
        return self._name

    @property
    def prim_path(self) -> str:
        return str(self._prim.GetPath())

    @property
    def prim(self) -> Usd.Prim:
        return self._prim

    @property
    def material(self) -> UsdShade.Material:
        return UsdShade.Material(self._prim)

    @property
    def shaders_list(self) -> list[UsdShade.Shader]:
        return [shaders.surface_shader(self._prim)]

    def _set(self, name: str, value: Any) -> None:
        shaders.set_input(self._prim, name, self._inputs[name], value)

    def _set_color(self, name: str, color: Sequence[float] | np.ndarray) -> None:
        self._set(name, tuple(as_numpy(color).astype(float).tolist()))

    def _get(self, name: str) -> Any:
        """Return the value of an input; None if it has none."""
        found = self.shaders_list[0].GetInput(name)
        return found.Get() if found else None

    def _get_array(self, name: str) -> np.ndarray | None:
        value = self._get(name)
        return None if value is None else np.array(value)
