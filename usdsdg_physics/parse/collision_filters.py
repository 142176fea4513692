"""Find the pairs of colliders that FilteredPairsAPI and collision groups keep from colliding."""

from collections.abc import Mapping
from itertools import combinations_with_replacement, product

from pxr import Sdf, Usd, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.stage.physics.instances import prim_of
from usdsdg_physics.parse.attributes import value
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.scene.records import Collider


def read_filtered_pairs(
    stage: Usd.Stage,
    colliders: Mapping[str, Collider],
    filtered: list[Usd.Prim],
    groups: list[Usd.Prim],
    *,
    inverted: bool = False,
) -> frozenset[tuple[str, str]]:
    """Return the pairs of collider paths that never collide, each pair sorted.

    Args:
        filtered: prims with FilteredPairsAPI.
        groups: collision groups.
        inverted: whether groups collide only where filteredGroups says so (physxScene:invertCollisionGroupFilter).
    """
    pairs: set[tuple[str, str]] = set()
    for prim in filtered:
        own = _below(prim.GetPath(), colliders)
        _warn_missing(prim, "physics:filteredPairs")
        for target in prim.GetRelationship("physics:filteredPairs").GetTargets():
            _add(pairs, own, _below(target, colliders))
    for prim in groups:
        _warn_missing(prim, "physics:filteredGroups", kind="PhysicsCollisionGroup")
    members = {prim.GetPath(): _members(prim, colliders) for prim in groups}
    for (path_a, in_a), (path_b, in_b) in combinations_with_replacement(sorted(members.items()), 2):
        if _groups_filtered(stage.GetPrimAtPath(path_a), stage.GetPrimAtPath(path_b)) != inverted:
            _add(pairs, in_a, in_b)
    return frozenset(pairs)


def _below(root: Sdf.Path, colliders: Mapping[str, Collider]) -> list[str]:
    """Return the colliders at or below a path; a rigid body stands for all colliders that it owns."""
    return [path for path in colliders if Sdf.Path(prim_of(path)).HasPrefix(root)]


def _warn_missing(prim: Usd.Prim, name: str, *, kind: str = "") -> None:
    """Name the targets of a relationship that are no prims, or not of a type."""
    targets = prim.GetRelationship(name).GetTargets() if prim.GetRelationship(name) else []
    found = ((path, prim.GetStage().GetPrimAtPath(path)) for path in targets)
    missing = [str(path) for path, other in found if not other or (kind and other.GetTypeName() != kind)]
    if missing:
        what = f"no {kind}" if kind else "no prim"
        warn_once(
            f"{prim.GetPath()}: {name} names {listed(missing)}, which is {what}, so it filters nothing. Correct it."
        )


def _members(group: Usd.Prim, colliders: Mapping[str, Collider]) -> list[str]:
    query = UsdPhysics.CollisionGroup(group).GetCollidersCollectionAPI().ComputeMembershipQuery()
    return [path for path in colliders if query.IsPathIncluded(Sdf.Path(prim_of(path)))]


def _groups_filtered(a: Usd.Prim, b: Usd.Prim) -> bool:
    return _filters(a, b.GetPath()) or _filters(b, a.GetPath())


def _filters(group: Usd.Prim, other: Sdf.Path) -> bool:
    listed = other in group.GetRelationship("physics:filteredGroups").GetTargets()
    return listed != bool(value(group, "physics:invertFilteredGroups", False))


def _add(pairs: set[tuple[str, str]], some: list[str], others: list[str]) -> None:
    for a, b in product(some, others):
        if a != b:
            pairs.add((a, b) if a < b else (b, a))
