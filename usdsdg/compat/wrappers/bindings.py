"""Materials bound to prims."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any, Protocol

from pxr import Usd, UsdShade

from usdsdg.errors import counted


class HasMaterials(Protocol):
    """A wrapper of materials."""

    @property
    def materials(self) -> list[UsdShade.Material]: ...


def bind(
    prims: Sequence[Usd.Prim],
    materials: HasMaterials | Sequence[HasMaterials],
    weaker_than_descendants: Sequence[float],
    *,
    purpose: str = "",
) -> None:
    """Bind the first material of each wrapper; one for all, or one for each.

    Raises:
        ValueError: there are neither one nor as many materials as prims.
    """
    given = list(materials) if isinstance(materials, (list, tuple)) else [materials]
    if len(given) not in (1, len(prims)):
        raise ValueError(
            f"{counted(len(given), 'material is', 'materials are')} given for {counted(len(prims), 'prim')}; give one "
            "for each or one for all"
        )
    for index, prim in enumerate(prims):
        material = given[0 if len(given) == 1 else index].materials[0]  # pyright: ignore[reportAttributeAccessIssue]
        bind_one(prim, material, weaker=bool(weaker_than_descendants[index]), purpose=purpose)


def bind_one(prim: Usd.Prim, material: UsdShade.Material, *, weaker: bool = False, purpose: str = "") -> None:
    """Bind a material; unless `weaker`, also over the bindings of descendants."""
    strength = UsdShade.Tokens.weakerThanDescendants if weaker else UsdShade.Tokens.strongerThanDescendants
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, strength, purpose or UsdShade.Tokens.allPurpose)


def bound(prim: Usd.Prim, *, purpose: str = "") -> str:
    """Return the path of the material bound to the prim itself; empty without one."""
    api = UsdShade.MaterialBindingAPI(prim)
    return str(api.GetDirectBinding(purpose or UsdShade.Tokens.allPurpose).GetMaterialPath())


def wrapper_class(name: str) -> Any:
    """Return a class or function of `isaacsim.core`, given as "module:name".

    Wrappers of materials are wrappers of prims themselves, so that those of prims name them and do not import them.
    """
    module, _, attribute = name.partition(":")
    return getattr(importlib.import_module(f"usdsdg.compat.isaacsim.core.{module}"), attribute)
