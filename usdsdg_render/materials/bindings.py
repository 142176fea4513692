"""Material bindings as UsdShade computes them, collections included."""

from collections.abc import Sequence

from pxr import Sdf, Usd, UsdShade

from usdsdg import errors

BINDING = "material:binding"


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
    """Warn of bindings that UsdShade drops silently: with too many or too few targets, or ones that do not exist."""
    seen: set[Sdf.Path] = set()
    for prim in unbound:
        while prim and prim.GetPath() not in seen:
            seen.add(prim.GetPath())
            for binding in prim.GetAuthoredPropertiesInNamespace("material"):
                is_binding = isinstance(binding, Usd.Relationship) and binding.GetName().startswith(BINDING)
                if is_binding and (fault := _fault(binding)):
                    errors.warn_once(f"{prim.GetPath()}: {fault}; displayColor is used. Correct {binding.GetName()}.")
            prim = prim.GetParent()


def _fault(binding: Usd.Relationship) -> str:
    """Return why a binding gives no material; "" where it gives one, or is blocked."""
    stage, targets = binding.GetStage(), binding.GetTargets()
    if not targets:
        return ""
    if not binding.GetName().startswith(f"{BINDING}:collection"):
        if len(targets) > 1:
            return f"{binding.GetName()} names {len(targets)} materials, so none counts"
        return "" if UsdShade.Material(stage.GetPrimAtPath(targets[0])) else f"its material {targets[0]} does not exist"
    if len(targets) != 2 or not targets[0].IsPropertyPath():
        return f"{binding.GetName()} names {', '.join(map(str, targets))} in place of a collection and a material"
    if not Usd.CollectionAPI.Get(stage, targets[0]):
        return f"the collection {targets[0]} does not exist, since its prim lacks that CollectionAPI"
    return "" if UsdShade.Material(stage.GetPrimAtPath(targets[1])) else f"its material {targets[1]} does not exist"
