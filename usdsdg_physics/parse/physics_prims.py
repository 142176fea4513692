"""Find the prims that matter to physics in one traversal of a stage."""

from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.physics.joints import ARTICULATION_ROOT
from usdsdg.stage.time_code import current_time, default_or_current_time, is_sampled, transform_varies
from usdsdg_physics.parse.attributes import (
    COLLISION,
    CONTACT_REPORT,
    FORCE,
    MATERIAL,
    RIGID_BODY,
    SURFACE_VELOCITY,
    value,
)
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.point_instancers import prototype_paths
from usdsdg_physics.parse.simulation_owners import has_scene
from usdsdg_physics.parse.unread import UnreadNames

LARGEST = 1e15  # of what is in the transform of a prim; numbers of 64 bits lose a rotation beside larger ones


@dataclass
class PhysicsPrims:
    """Prims by their role in the simulation; the lists of paths are of prims that are left out."""

    scenes: list[Usd.Prim] = field(default_factory=list)
    bodies: list[Usd.Prim] = field(default_factory=list)
    colliders: list[tuple[Usd.Prim, Usd.Prim | None]] = field(default_factory=list)  # with the body that owns it
    filtered: list[Usd.Prim] = field(default_factory=list)  # with FilteredPairsAPI
    groups: list[Usd.Prim] = field(default_factory=list)  # collision groups
    forces: list[tuple[Usd.Prim, Usd.Prim | None]] = field(default_factory=list)  # with the body that they push
    reports: list[Usd.Prim] = field(default_factory=list)  # with PhysxContactReportAPI
    static_belts: list[str] = field(default_factory=list)  # with PhysxSurfaceVelocityAPI, but no rigid body
    joints: list[Usd.Prim] = field(default_factory=list)
    articulations: list[Usd.Prim] = field(default_factory=list)  # with ArticulationRootAPI
    instancers: list[Usd.Prim] = field(default_factory=list)  # PointInstancers that are no part of a prototype
    animated: list[Usd.Prim] = field(default_factory=list)  # kinematic bodies and static colliders that samples move
    sampled: list[Sdf.Path] = field(default_factory=list)  # dynamic bodies of which xform ops have samples
    instanced_bodies: list[str] = field(default_factory=list)  # rigid bodies inside instances
    left_behind: list[str] = field(default_factory=list)  # rigid bodies that are disabled, below others that move
    loose_materials: list[Usd.Prim] = field(default_factory=list)  # with a physics MaterialAPI, and no Materials
    without_scene: list[str] = field(default_factory=list)  # bodies and colliders that no PhysicsScene simulates
    nonfinite: list[str] = field(default_factory=list)  # whose transform is not finite, too large, or no numbers
    unread: UnreadNames = field(default_factory=UnreadNames)  # schemas and attributes without effect


@dataclass(frozen=True)
class _Owner:
    """What colliders at a prim belong to."""

    body: Usd.Prim | None = None  # the nearest rigid body at or above it; None where that is disabled, or there is none
    outside: bool = False  # that body is in no PhysicsScene, so that nothing simulates what belongs to it


_STATIC = _Owner()


def find_physics_prims(stage: Usd.Stage, root: Sdf.Path) -> PhysicsPrims:
    """Find the prims at or below `root`; a collider belongs to the nearest rigid body at or above it, if enabled."""
    found, cache = PhysicsPrims(), UsdGeom.XformCache(current_time())
    start = stage.GetPrimAtPath(root)
    if not start or not start.IsActive():
        return found
    owners = {root.GetParentPath(): _owner_at(start.GetParent())}
    prims = iter(Usd.PrimRange(start, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    for prim in prims:
        applied = prim.GetAppliedSchemas()
        found.unread.visit(prim)
        owner = _owner_from_above(prim, applied, owners.get(prim.GetPath().GetParentPath(), _STATIC), found)
        is_body = _is_body(prim, applied)
        if (is_body or COLLISION in applied) and not _has_pose(prim, cache):
            found.nonfinite.append(str(prim.GetPath()))
            prims.PruneChildren()
            continue
        if is_body:
            owner = _add_body(prim, owner, found)
        owners[prim.GetPath()] = owner
        if COLLISION in applied and not owner.outside:
            _add_collider(prim, owner, found)
        _add_by_schemas(prim, applied, owner, found)
        _add_by_type(prim, found)
    if found.instancers:
        _leave_out_prototypes(found)
    _find_animated(found)
    return found


def _owner_from_above(prim: Usd.Prim, applied: list[str], above: _Owner, found: PhysicsPrims) -> _Owner:
    """Return what colliders at a prim belong to unless it is a rigid body, from what those at its parent belong to."""
    if _is_disabled(prim, applied):
        if above.body is not None and not value(above.body, "physics:kinematicEnabled", False):
            found.left_behind.append(str(prim.GetPath()))
        return _STATIC
    return _STATIC if above is not _STATIC and _resets_xform_stack(prim) else above


def _add_body(prim: Usd.Prim, above: _Owner, found: PhysicsPrims) -> _Owner:
    """Add a rigid body, and return what colliders at it belong to: the body above where it cannot be moved."""
    if prim.IsInstanceProxy():
        found.instanced_bodies.append(str(prim.GetPath()))
        return above
    if has_scene(prim):
        found.bodies.append(prim)
        return _Owner(prim)
    found.without_scene.append(str(prim.GetPath()))
    return _Owner(outside=True)


def _add_collider(prim: Usd.Prim, owner: _Owner, found: PhysicsPrims) -> None:
    if owner.body is not None or has_scene(prim):
        found.colliders.append((prim, owner.body))
    else:
        found.without_scene.append(str(prim.GetPath()))


def _add_by_schemas(prim: Usd.Prim, applied: list[str], owner: _Owner, found: PhysicsPrims) -> None:
    """Add a prim by its applied schemas, apart from those of rigid bodies and colliders."""
    if FORCE in applied:
        found.forces.append((prim, owner.body))
    if MATERIAL in applied and prim.GetTypeName() != "Material":
        found.loose_materials.append(prim)
    if CONTACT_REPORT in applied:
        found.reports.append(prim)
    if SURFACE_VELOCITY in applied and not _is_body(prim, applied):
        found.static_belts.append(str(prim.GetPath()))
    if ARTICULATION_ROOT in applied:
        found.articulations.append(prim)
    if "PhysicsFilteredPairsAPI" in applied:
        found.filtered.append(prim)


def _leave_out_prototypes(found: PhysicsPrims) -> None:
    """Leave out what PointInstancers draw: a prototype neither collides nor moves by itself."""
    roots = set(prototype_paths(found.instancers))

    def is_part(prim: Usd.Prim, *, itself: bool = True) -> bool:
        path = prim.GetPath() if itself else prim.GetPath().GetParentPath()
        return any(prefix in roots for prefix in path.GetPrefixes())

    found.bodies = [prim for prim in found.bodies if not is_part(prim)]
    found.colliders = [(prim, owner) for prim, owner in found.colliders if not is_part(prim)]
    found.forces = [(prim, owner) for prim, owner in found.forces if not is_part(prim)]
    found.reports = [prim for prim in found.reports if not is_part(prim)]
    found.joints = [prim for prim in found.joints if not is_part(prim)]
    found.instancers = [prim for prim in found.instancers if not is_part(prim, itself=False)]


def _owner_at(prim: Usd.Prim) -> _Owner:
    """Return what colliders at a prim belong to, from all prims at and above it."""
    while prim and not prim.IsPseudoRoot():
        applied = prim.GetAppliedSchemas()
        if _is_body(prim, applied) and not prim.IsInstanceProxy():
            return _Owner(prim) if has_scene(prim) else _Owner(outside=True)
        if _resets_xform_stack(prim) or _is_disabled(prim, applied):
            return _STATIC
        prim = prim.GetParent()
    return _STATIC


def _is_body(prim: Usd.Prim, applied: list[str]) -> bool:
    return RIGID_BODY in applied and bool(value(prim, "physics:rigidBodyEnabled", True))


def _is_disabled(prim: Usd.Prim, applied: list[str]) -> bool:
    """Return whether a prim is a rigid body that is switched off: as in PhysX its colliders are static."""
    return RIGID_BODY in applied and not _is_body(prim, applied)


def _resets_xform_stack(prim: Usd.Prim) -> bool:
    xformable = UsdGeom.Xformable(prim)
    return bool(xformable) and xformable.GetResetXformStack()


def _add_by_type(prim: Usd.Prim, found: PhysicsPrims) -> None:
    kind = str(prim.GetTypeName())
    if kind == "PhysicsScene":
        found.scenes.append(prim)
    elif kind == "PhysicsCollisionGroup":
        found.groups.append(prim)
    elif kind == "PointInstancer":
        found.instancers.append(prim)
    elif kind.startswith("Phys") and kind.endswith("Joint"):
        found.joints.append(prim)


def _has_pose(prim: Usd.Prim, cache: UsdGeom.XformCache) -> bool:
    """Whether the matrix of a prim can be inverted as one of numbers; NaN is no number."""
    try:
        matrix = cache.GetLocalToWorldTransform(prim)
    except Tf.ErrorException:  # a file may declare an op with another type
        return False
    return bool((np.abs(matrix) <= LARGEST).all())


def _find_animated(found: PhysicsPrims) -> None:
    """Find the kinematic bodies and static colliders that time samples move, and dynamic bodies that have samples."""
    known: dict[Sdf.Path, bool] = {}
    ignored, planes, below = [], [], []
    for prim in found.bodies:
        moves = _is_moved(prim, known)
        if value(prim, "physics:kinematicEnabled", False):
            found.animated += [prim] if moves else []
            continue
        sampled = [op for op in _ops(prim) if is_sampled(op.GetAttr())]
        found.sampled += [prim.GetPath()] if sampled else []
        ignored += [prim] if moves or any(map(_has_other_default, sampled)) else []
    for prim, owner in found.colliders:
        if owner is None and _is_moved(prim, known):
            (planes if prim.GetTypeName() == "Plane" else found.animated).append(prim)
        elif owner is not None and prim != owner and _is_moved_below(prim, owner):
            below.append(prim)
    if ignored:
        warn_once(
            "rigid bodies that are not kinematic move by physics alone, not by time samples or splines of theirs or of "
            f"prims above them: {_paths(ignored)}. They begin at default values beside the samples, and without these "
            "where the samples have them when the simulation begins. Enable physics:kinematicEnabled on bodies that "
            "shall follow theirs."
        )
    if planes:
        warn_once(
            f"time samples and splines do not move unbounded planes, which stay where they are when the simulation "
            f"begins: {_paths(planes)}. Use thin Cubes."
        )
    if below:
        warn_once(
            f"time samples and splines do not move colliders in their rigid bodies, where they stay as they are when "
            f"the simulation begins: {_paths(below)}. Make them rigid bodies with physics:kinematicEnabled, which "
            "follow theirs."
        )


def _paths(prims: list[Usd.Prim]) -> str:
    return listed([str(prim.GetPath()) for prim in prims])


def _is_moved(prim: Usd.Prim, known: dict[Sdf.Path, bool]) -> bool:
    """Return whether the transform of a prim or of an ancestor varies with time; a single sample does not."""
    path = prim.GetPath()
    if path not in known:
        known[path] = transform_varies(prim)
        if not known[path] and not prim.IsPseudoRoot() and not _resets_xform_stack(prim):
            known[path] = _is_moved(prim.GetParent(), known)
    return known[path]


def _is_moved_below(prim: Usd.Prim, owner: Usd.Prim) -> bool:
    """Return whether time samples move a collider relative to its body."""
    while prim and prim != owner:
        if transform_varies(prim):
            return True
        prim = prim.GetParent()
    return False


def _ops(prim: Usd.Prim) -> list[UsdGeom.XformOp]:
    xformable = UsdGeom.Xformable(prim)
    return xformable.GetOrderedXformOps() if xformable else []


def _has_other_default(op: UsdGeom.XformOp) -> bool:
    """Return whether an op with samples has a default value beside them, and another than theirs now."""
    return op.Get(default_or_current_time(op.GetAttr())) != op.Get(current_time())
