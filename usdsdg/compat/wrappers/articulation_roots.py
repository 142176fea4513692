"""Settings of whole articulations, which are on the prim with the ArticulationRootAPI."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics

from usdsdg.stage.schemas import physx


def root_of(prim: Usd.Prim) -> Usd.Prim:
    """Return the prim at or below `prim` with the ArticulationRootAPI; `prim` itself without one."""
    below = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return next((each for each in below if each.HasAPI(UsdPhysics.ArticulationRootAPI)), prim)


def read(prims: Sequence[Usd.Prim], name: str, dtype: type) -> np.ndarray:
    """Return an attribute of PhysxArticulationAPI (N,), with the default of the schema where none is authored."""
    found: list[Any] = []
    for prim in map(root_of, prims):
        # The definition of the schema knows the default where the schema is not applied.
        definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("PhysxArticulationAPI")
        attribute = prim.GetAttribute(f"physxArticulation:{name}")
        value = attribute.Get() if attribute else None
        found.append(definition.GetAttributeFallbackValue(f"physxArticulation:{name}") if value is None else value)
    return np.array(found, dtype)


def write(prims: Sequence[Usd.Prim], name: str, values: Sequence[Any]) -> None:
    """Author an attribute of PhysxArticulationAPI."""
    for prim, value in zip(map(root_of, prims), values, strict=True):
        physx.PhysxArticulationAPI.Apply(prim)
        prim.GetAttribute(f"physxArticulation:{name}").Set(value)
