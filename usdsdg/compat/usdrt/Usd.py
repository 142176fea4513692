"""`usdrt.Usd`: the same names as `pxr.Usd`, and stages by the id of `omni.usd`."""

from __future__ import annotations

from typing import Any

from pxr import Sdf
from pxr import Usd as _Usd
from pxr.Usd import *  # noqa: F403

from usdsdg.session.stage_context import stage_by_id


class Stage:
    """A stage, of which the values that Fabric would hold are those of USD."""

    def __init__(self, stage: _Usd.Stage) -> None:
        self._stage = stage

    @staticmethod
    def Attach(stage_id: int) -> Stage:
        return Stage(stage_by_id(stage_id))

    def GetPrimsWithAppliedAPIName(self, name: str) -> list[Sdf.Path]:
        """Return paths of prims with the applied schema, under any instance name."""
        return [prim.GetPath() for prim in self._stage.Traverse() if _has_api(prim, name)]

    def GetPrimsWithTypeName(self, name: str) -> list[Sdf.Path]:
        return [prim.GetPath() for prim in self._stage.Traverse() if prim.GetTypeName() == name]

    def GetPrimsWithTypeAndAppliedAPIName(self, type_name: str, api_names: list[str]) -> list[Sdf.Path]:
        """Return paths of prims of the type, or of any if that is empty, with all applied schemas."""
        prims = [prim for prim in self._stage.Traverse() if not type_name or prim.GetTypeName() == type_name]
        return [prim.GetPath() for prim in prims if all(_has_api(prim, name) for name in api_names)]

    def HasPrimAtPath(self, path: Sdf.Path | str) -> bool:
        return bool(self._stage.GetPrimAtPath(path))

    def SynchronizeToFabric(self, *_: Any) -> None:
        """Do nothing: there is one copy of the values."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stage, name)  # GetPrimAtPath, Traverse, ...


def _has_api(prim: _Usd.Prim, name: str) -> bool:
    return any(applied == name or applied.startswith(f"{name}:") for applied in prim.GetAppliedSchemas())
