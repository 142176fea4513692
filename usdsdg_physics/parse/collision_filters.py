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
    merged = _merged(groups)
    members = [sorted({path for group in each for path in _members(group, colliders)}) for each in merged]
    for a, b in combinations_with_replacement(range(len(merged)), 2):
        if (_filters(merged[a], merged[b]) or _filters(merged[b], merged[a])) != inverted:
            _add(pairs, members[a], members[b])
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


def _merged(groups: list[Usd.Prim]) -> list[list[Usd.Prim]]:
    """Return the groups in path order, those of the same physics:mergeGroup together: they are as one."""
    found: dict[str, list[Usd.Prim]] = {}
    for group in sorted(groups, key=lambda prim: prim.GetPath()):
        # No name of a merged group begins as a path does.
        found.setdefault(str(value(group, "physics:mergeGroup", "")) or str(group.GetPath()), []).append(group)
    return list(found.values())


def _filters(groups: list[Usd.Prim], others: list[Usd.Prim]) -> bool:
    """Return whether groups that are as one filter others that are."""
    targets = {path for group in groups for path in group.GetRelationship("physics:filteredGroups").GetTargets()}
    listed = any(other.GetPath() in targets for other in others)
    return listed != any(value(group, "physics:invertFilteredGroups", False) for group in groups)


def _add(pairs: set[tuple[str, str]], some: list[str], others: list[str]) -> None:
    for a, b in product(some, others):
        if a != b:
            pairs.add((a, b) if a < b else (b, a))
