"""`usdrt`: look-up of prims by schema or type on the USD stage, the part of Fabric that scripts use."""

from __future__ import annotations

from types import SimpleNamespace

from pxr import Gf, Sdf, Vt
from pxr import Usd as _Usd

from usdsdg.session.stage_context import stage_by_id


class _Stage:
    def __init__(self, stage: _Usd.Stage) -> None:
        self._stage = stage

    @staticmethod
    def Attach(stage_id: int) -> _Stage:
        return _Stage(stage_by_id(stage_id))

    def GetPrimsWithAppliedAPIName(self, name: str) -> list[Sdf.Path]:
        """Return paths of prims with the applied schema, under any instance name."""
        return [prim.GetPath() for prim in self._stage.Traverse() if _has_api(prim, name)]

    def GetPrimsWithTypeName(self, name: str) -> list[Sdf.Path]:
        return [prim.GetPath() for prim in self._stage.Traverse() if prim.GetTypeName() == name]

    def GetPrimAtPath(self, path: Sdf.Path | str) -> _Usd.Prim:
        return self._stage.GetPrimAtPath(path)


def _has_api(prim: _Usd.Prim, name: str) -> bool:
    return any(applied == name or applied.startswith(f"{name}:") for applied in prim.GetAppliedSchemas())


Usd = SimpleNamespace(Stage=_Stage)

__all__ = ["Gf", "Sdf", "Usd", "Vt"]
