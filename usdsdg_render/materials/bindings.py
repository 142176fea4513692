"""Material bindings as UsdShade computes them, collections included."""

from collections.abc import Iterable, Sequence, Set

from pxr import Sdf, Usd, UsdShade

from usdsdg import errors
from usdsdg_render.materials.binding_owners import BindingOwners

BINDING = "material:binding"
FULL = f"{BINDING}:full"


def bound_materials(prims: Sequence[Usd.Prim], owners: BindingOwners | None = None) -> list[Usd.Prim | None]:
    """Return the material bound to each prim, of purpose full, else all-purpose, else preview; None where none is.

    owners: is told of all bindings that this depends on.
    """
    if not prims:
        return []
    api = UsdShade.MaterialBindingAPI
    materials, winners = api.ComputeBoundMaterials(prims, UsdShade.Tokens.full)
    found = [material.GetPrim() for material in materials]
    unbound = [k for k, prim in enumerate(found) if not prim]
    if unbound:
        preview, of_preview = api.ComputeBoundMaterials([prims[k] for k in unbound], UsdShade.Tokens.preview)
        for k, material, winner in zip(unbound, preview, of_preview):
            found[k], winners[k] = material.GetPrim(), winner
    # Mostly all bindings are in order, and looking for those that are not for each prim takes longer than binding.
    if _note_bindings(prims, {prim.GetPath() for prim in found if prim}, owners):
        _warn_of_missing([prims[k] for k in unbound if not found[k]])
        _warn_of_passed_over((prim, winner) for prim, winner in zip(prims, winners) if winner)
    return [prim if prim else None for prim in found]


def _note_bindings(prims: Iterable[Usd.Prim], given: Set[Sdf.Path], owners: BindingOwners | None) -> bool:
    """Tell `owners` of the bindings of prims and of those above them; return whether any gives no material.

    given: paths of materials that exist.
    """
    seen: set[Sdf.Path] = set()
    has_faults = False
    for prim in prims:
        while prim and (path := prim.GetPath()) not in seen:
            seen.add(path)
            named: list[Sdf.Path] | None = []
            for binding in prim.GetAuthoredPropertiesInNamespace("material"):
                if not isinstance(binding, Usd.Relationship) or not binding.GetName().startswith(BINDING):
                    continue
                targets = binding.GetTargets()
                if len(targets) != 1 or targets[0] not in given:
                    has_faults = has_faults or bool(_fault(binding))
                if binding.GetName().startswith(f"{BINDING}:collection"):
                    named = None
                elif named is not None:
                    named += targets
                    if not all(map(Sdf.Path.IsPrimPath, targets)):  # relationships that forward it
                        named += binding.GetForwardedTargets()
            if owners is not None and named != []:
                owners.note(path, named)
            prim = prim.GetParent()
    return has_faults


def _warn_of_passed_over(bound: Iterable[tuple[Usd.Prim, Usd.Relationship]]) -> None:
    """Warn of direct bindings to nothing in whose place those of another purpose count; `bound`: prims with these."""
    seen: set[tuple[str, Sdf.Path]] = set()
    for prim, winner in bound:
        name = winner.GetName().replace(f"{BINDING}:collection", BINDING)
        if name.startswith(FULL):
            continue
        # The purpose comes first: a material of purpose full of the root is before others of the prim itself.
        for before in (FULL, BINDING) if name.startswith(f"{BINDING}:preview") else (FULL,):
            _warn_from(prim, before, seen)


def _warn_from(prim: Usd.Prim, name: str, seen: set[tuple[str, Sdf.Path]]) -> None:
    """Warn of a binding to nothing, by its name, of the prim and those above it."""
    while prim and (name, path := prim.GetPath()) not in seen:
        seen.add((name, path))
        binding = prim.GetRelationship(name)
        if binding and (fault := _fault(binding)):
            errors.warn_once(f"{path}: {fault}; another binding counts in its place. Correct {name}.")
        prim = prim.GetParent()


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
