"""Material bindings as UsdShade computes them, collections included."""

from collections.abc import Sequence

from pxr import Sdf, Usd, UsdShade

from usdsdg import errors


def bound_materials(prims: Sequence[Usd.Prim]) -> list[Usd.Prim | None]:
    """Return the material bound to each prim, of purpose full, else all-purpose, else preview; None where none is."""
    if not prims:
        return []
    api = UsdShade.MaterialBindingAPI
    found = [material.GetPrim() for material in api.ComputeBoundMaterials(prims, UsdShade.Tokens.full)[0]]
    unbound = [k for k, prim in enumerate(found) if not prim]
    if unbound:
        preview = api.ComputeBoundMaterials([prims[k] for k in unbound], UsdShade.Tokens.preview)[0]
        for k, material in zip(unbound, preview):
            found[k] = material.GetPrim()
        _warn_of_missing([prims[k] for k in unbound if not found[k]])
    return [prim if prim else None for prim in found]


def _warn_of_missing(unbound: list[Usd.Prim]) -> None:
    """Warn of bindings that UsdShade drops silently: those with several targets, or a target that is no material."""
    seen: set[Sdf.Path] = set()
    for prim in unbound:
        while prim and prim.GetPath() not in seen:
            seen.add(prim.GetPath())
            binding = prim.GetRelationship("material:binding")
            targets = binding.GetTargets() if binding else []
            if len(targets) > 1:
                errors.warn_once(
                    f"{prim.GetPath()}: material:binding names {len(targets)} materials, so none counts; displayColor "
                    f"is used. Name one."
                )
            elif targets and not UsdShade.Material(prim.GetStage().GetPrimAtPath(targets[0])):
                errors.warn_once(
                    f"{prim.GetPath()}: its material {targets[0]} does not exist; displayColor is used. Correct "
                    f"material:binding."
                )
            prim = prim.GetParent()
