"""`isaacsim.core.experimental.utils.prim`: finding prims, their schemas, variants and attributes."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from pxr import Sdf, Usd, UsdPhysics

from usdsdg.compat import used_stage
from usdsdg.compat.wrappers.prim_paths import existing_prim, matching_paths, prim_of
from usdsdg.errors import BadPrim
from usdsdg.stage.prims.variants import select_variant

PrimOrPath = str | Usd.Prim
Predicate = Callable[[Usd.Prim, str], bool]

get_prim_at_path = prim_of


def get_prim_path(prim: Usd.Prim | Usd.SchemaBase | str | Sdf.Path) -> str:
    return str(prim if isinstance(prim, (str, Sdf.Path)) else prim.GetPath())


# --- finding prims ---
def find_matching_prim_paths(path: str, *, traverse: bool = False) -> list[str]:
    """Return the paths of prims that match a path of which every part may be a regular expression.

    With `traverse` all paths are returned at whose beginning the whole expression matches, or those below a path.
    """
    stage = used_stage.current_stage()
    if not traverse:
        return matching_paths(path)
    if Sdf.Path.IsValidPathString(path) and stage.GetPrimAtPath(path):
        return [str(prim.GetPath()) for prim in Usd.PrimRange(stage.GetPrimAtPath(path))]
    pattern = re.compile(path)
    return [str(prim.GetPath()) for prim in stage.Traverse() if pattern.match(str(prim.GetPath()))]


def get_all_matching_child_prims(
    prim: PrimOrPath, *, predicate: Predicate, include_self: bool = False, max_depth: int | None = None
) -> list[Usd.Prim]:
    """Return the prims below for which `predicate(prim, path)` holds, those nearer to the prim first.

    Raises:
        ValueError: `max_depth` is negative.
    """
    if max_depth is not None and max_depth < 0:
        raise ValueError(f"max_depth is 0 or more, not {max_depth}")
    found = []
    pending = deque([(existing_prim(prim), 0)])
    while pending:
        each, depth = pending.popleft()
        if (depth or include_self) and predicate(each, str(each.GetPath())):
            found.append(each)
        if max_depth is None or depth < max_depth:
            pending.extend((child, depth + 1) for child in each.GetChildren())
    return found


def get_first_matching_child_prim(
    prim: PrimOrPath, *, predicate: Predicate, include_self: bool = False
) -> Usd.Prim | None:
    """Return the nearest prim below for which `predicate(prim, path)` holds."""
    return next(iter(get_all_matching_child_prims(prim, predicate=predicate, include_self=include_self)), None)


def get_first_matching_parent_prim(
    prim: PrimOrPath, *, predicate: Predicate, include_self: bool = False
) -> Usd.Prim | None:
    """Return the nearest prim above for which `predicate(prim, path)` holds."""
    each = existing_prim(prim)
    each = each if include_self else each.GetParent()
    while each and not each.IsPseudoRoot():
        if predicate(each, str(each.GetPath())):
            return each
        each = each.GetParent()
    return None


# --- schemas ---
def has_api(prim: PrimOrPath, api: str | type | Sequence[str | type], *, test: str = "all") -> bool:
    """Whether "all", "any" or "none" of the schemas are applied; a text is a name as on the stage.

    Raises:
        ValueError: there is no such test.
    """
    tests = {"all": all, "any": any, "none": lambda each: not any(each)}
    if test not in tests:
        raise ValueError(f"there is no test {test!r}; give 'all', 'any' or 'none'")
    found = existing_prim(prim)
    schemas = api if isinstance(api, (list, tuple)) else [api]
    names = found.GetAppliedSchemas()
    return tests[test]([each in names if isinstance(each, str) else found.HasAPI(each) for each in schemas])


def ensure_api(prim: PrimOrPath, api: type, *args: Any, **kwargs: Any) -> Any:
    """Apply a schema unless it is applied; return its object."""
    found = existing_prim(prim)
    return api(found, *args, **kwargs) if found.HasAPI(api) else api.Apply(found, *args, **kwargs)  # pyright: ignore[reportAttributeAccessIssue]


def is_prim_non_root_articulation_link(prim: PrimOrPath) -> bool:
    """Whether the prim is a rigid body that a joint connects, below the root of an articulation."""
    body = existing_prim(prim)
    root = get_first_matching_parent_prim(body, predicate=lambda each, _: each.HasAPI(UsdPhysics.ArticulationRootAPI))
    if root is None or not body.HasAPI(UsdPhysics.RigidBodyAPI):
        return False
    joints = get_all_matching_child_prims(root, predicate=lambda each, _: each.IsA(UsdPhysics.Joint))
    return any(_connects(UsdPhysics.Joint(joint), body) for joint in joints)


def _connects(joint: UsdPhysics.Joint, body: Usd.Prim) -> bool:
    if joint.GetExcludeFromArticulationAttr().Get():
        return False
    return body.GetPath() in [*joint.GetBody0Rel().GetTargets(), *joint.GetBody1Rel().GetTargets()]


# --- variants and attributes ---
def set_prim_variants(prim: PrimOrPath, *, variants: Sequence[tuple[str, str]]) -> None:
    """Select variants, as (set, variant); an empty variant clears the selection.

    Raises:
        ValueError: the prim has no such set or variant.
    """
    target = existing_prim(prim)
    sets = target.GetVariantSets()
    for name, variant in variants:
        if not variant and name in sets.GetNames():
            sets.GetVariantSet(name).ClearVariantSelection()
        else:
            select_variant(target, name, variant)


def get_prim_variants(prim: PrimOrPath) -> list[tuple[str, str]]:
    """Return the selected variants as (set, variant), sorted by set."""
    sets = existing_prim(prim).GetVariantSets()
    return [(name, sets.GetVariantSelection(name)) for name in sorted(sets.GetNames())]


def get_prim_variant_collection(prim: PrimOrPath) -> dict[str, list[str]]:
    """Return the variants of each set."""
    sets = existing_prim(prim).GetVariantSets()
    return {name: list(sets.GetVariantSet(name).GetVariantNames()) for name in sets.GetNames()}


def create_prim_attribute(
    prim: PrimOrPath, *, name: str, type_name: str | Sdf.ValueTypeName, exist_ok: bool = True
) -> Usd.Attribute:
    """Create a custom attribute; return the existing one if it has this type.

    Raises:
        RuntimeError: it exists, and not `exist_ok`.
        ValueError: it exists with another type, or there is no such type.
    """
    found = existing_prim(prim)
    kind = Sdf.ValueTypeNames.Find(type_name) if isinstance(type_name, str) else type_name
    if not kind:
        raise ValueError(f"USD has no type {type_name!r}")
    if not found.HasAttribute(name):
        return found.CreateAttribute(name, kind, custom=True)
    attribute = found.GetAttribute(name)
    if not exist_ok:
        raise RuntimeError(f"{attribute.GetPath()} exists already")
    if attribute.GetTypeName() != kind:
        raise ValueError(f"{attribute.GetPath()} exists already, as {attribute.GetTypeName()} and not {kind}")
    return attribute


def get_prim_attribute_value(prim: PrimOrPath, attribute_name: str) -> Any:
    """Return the value of an attribute.

    Raises:
        BadPrim: the prim has no such attribute.
    """
    found = existing_prim(prim)
    if not found.HasAttribute(attribute_name):
        raise BadPrim(f"{found.GetPath()} has no attribute {attribute_name!r}")
    return found.GetAttribute(attribute_name).Get()


def get_prim_attribute_names(prim: PrimOrPath) -> list[str]:
    return [attribute.GetName() for attribute in existing_prim(prim).GetAttributes()]
