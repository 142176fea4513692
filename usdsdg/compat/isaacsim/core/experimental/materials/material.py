"""The base of wrappers of materials, which define those that are missing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from pxr import Usd, UsdShade

from usdsdg.compat import used_stage
from usdsdg.compat.isaacsim.core.experimental.prims import Prim
from usdsdg.compat.wrappers import prim_paths


class Material(Prim):
    """Materials of one kind."""

    _noun: ClassVar[str] = "material"  # of the error about a prim of another kind; "" takes the name of the class

    def __init__(self, paths: str | Sequence[str]) -> None:
        """Wrap the materials at these paths, or define them.

        Raises:
            AssertionError: a prim is no material of this kind.
            ValueError: some prims exist and others do not.
        """
        existing, missing = self.resolve_paths(paths)
        for path in missing:
            self._define(path)
        for path in existing:
            if not self._is_kind(prim_paths.prim_of(path)):
                raise AssertionError(f"{path} is no {self._noun or type(self).__name__}")
        super().__init__(existing or missing, resolve_paths=False)

    @property
    def materials(self) -> list[UsdShade.Material]:
        return [UsdShade.Material(prim) for prim in self.prims]

    @classmethod
    def _define(cls, path: str) -> None:
        UsdShade.Material.Define(used_stage.current_stage(), path)

    @classmethod
    def _is_kind(cls, prim: Usd.Prim) -> bool:
        return prim.IsA(UsdShade.Material)
