"""Find the prims that matter to physics in one traversal of a stage, and warn of those that cannot be simulated."""

from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.physics.joints import ARTICULATION_ROOT
from usdsdg.stage.time_code import current_time, default_or_current_time, is_sampled, transform_varies
from usdsdg_physics.parse.attributes import (
    COLLISION,
    CONTACT_REPORT,
    FORCE,
    MASS,
    MATERIAL,
    RIGID_BODY,
    SURFACE_VELOCITY,
    has_api,
    value,
)
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.point_instancers import prototype_paths
from usdsdg_physics.parse.simulation_owners import has_scene, warn_several_scenes, warn_without_scene
from usdsdg_physics.parse.unread import UnreadNames

_LARGEST = 1e15  # of what is in the transform of a prim; numbers of 64 bits lose a rotation beside larger ones


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
    nonfinite: list[str] = field(default_factory=list)  # with a transform that is not finite, or too large
    unread: UnreadNames = field(default_factory=UnreadNames)  # schemas and attributes without effect


def find_physics_prims(stage: Usd.Stage, root: Sdf.Path) -> PhysicsPrims:
    """Find the prims at or below `root`; a collider belongs to the nearest rigid body at or above it, if enabled."""
    found, cache = PhysicsPrims(), UsdGeom.XformCache(current_time())
    owners: dict[Sdf.Path, Usd.Prim | None] = {}
    unowned: set[Sdf.Path] = set()  # bodies without a scene, and what is below them
    start = stage.GetPrimAtPath(root)
    if not start or not start.IsActive():
        return found
    owners[root.GetParentPath()], outside = _owner_of(start.GetParent())
    unowned |= {root.GetParentPath()} if outside else set()
    prims = iter(Usd.PrimRange(start, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    for prim in prims:
        path = prim.GetPath()
        owner = owners.get(path.GetParentPath())
        applied = prim.GetAppliedSchemas()
        found.unread.visit(prim)
        disabled = _is_disabled(prim, applied)
        if disabled and owner is not None and not value(owner, "physics:kinematicEnabled", False):
            found.left_behind.append(str(path))
        outside = path.GetParentPath() in unowned
        if disabled or ((owner is not None or outside) and _resets_xform_stack(prim)):
            owner, outside = None, False
        body = _is_body(prim, applied)
        if (body or COLLISION in applied) and not _is_numeric(cache.GetLocalToWorldTransform(prim)):
            found.nonfinite.append(str(path))
            prims.PruneChildren()
            continue
        if body:
            if prim.IsInstanceProxy():
                found.instanced_bodies.append(str(path))
            elif has_scene(prim):
                found.bodies.append(prim)
                owner, outside = prim, False
            else:
                found.without_scene.append(str(path))
                owner, outside = None, True
        owners[path] = owner
        unowned |= {path} if outside else set()
        if COLLISION in applied and not outside:
            if owner is not None or has_scene(prim):
                found.colliders.append((prim, owner))
            else:
                found.without_scene.append(str(path))
        if FORCE in applied:
            found.forces.append((prim, owner))
        if MATERIAL in applied and prim.GetTypeName() != "Material":
            found.loose_materials.append(prim)
        if CONTACT_REPORT in applied:
            found.reports.append(prim)
        if SURFACE_VELOCITY in applied and not body:
            found.static_belts.append(str(path))
        if ARTICULATION_ROOT in applied:
            found.articulations.append(prim)
        if "PhysicsFilteredPairsAPI" in applied:
            found.filtered.append(prim)
        _add_by_type(prim, found)
    if found.instancers:
        _leave_out_prototypes(found)
    _find_animated(found)
    return found


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


def _owner_of(prim: Usd.Prim) -> tuple[Usd.Prim | None, bool]:
    """Return the nearest rigid body at or above a prim, and whether it has no scene; None where it is disabled."""
    while prim and not prim.IsPseudoRoot():
        applied = prim.GetAppliedSchemas()
        if _is_body(prim, applied) and not prim.IsInstanceProxy():
            return (prim, False) if has_scene(prim) else (None, True)
        if _resets_xform_stack(prim) or _is_disabled(prim, applied):
            return None, False
        prim = prim.GetParent()
    return None, False


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


def warn_unsupported(found: PhysicsPrims) -> None:
    """Warn of what will not be simulated, or not as authored, each once and with its remedy."""
    found.unread.warn()
    _warn_left_out(found)


def warn_no_collider(bodies: Collection[str], owners: Collection[str]) -> None:
    """Warn of the bodies that own no collider."""
    for path in bodies:
        if path not in owners:
            warn_once(
                f"{path} has RigidBodyAPI but no collider below it, so it falls through everything. Apply "
                "UsdPhysics.CollisionAPI to a gprim at or under it."
            )


def warn_filled(paths: list[str]) -> None:
    """Warn of meshes whose triangles do not collide, but their convex hulls, which fill hollows."""
    if paths:
        warn_once(
            "as in PhysX, triangles do not collide on bodies that move by themselves, nor in triggers: with the "
            f"approximation 'none' these become their convex hulls, which fill hollows: {listed(paths)}. Set "
            "physics:approximation to 'convexDecomposition' to keep hollows, or to 'convexHull' if that is meant.",
            key="convex hulls instead of none",
        )


def _is_numeric(matrix: Gf.Matrix4d) -> bool:
    """Whether a matrix can be inverted as one of numbers; NaN is no number."""
    return bool((np.abs(matrix) <= _LARGEST).all())


def _warn_left_out(found: PhysicsPrims) -> None:
    if found.nonfinite:
        warn_once(
            f"these have a transform that is not a number, or has one above {_LARGEST:g}, and are not simulated: "
            f"{listed(found.nonfinite)}. Author a finite translation, rotation and scale on them and above them."
        )
    if found.instanced_bodies:
        warn_once(
            f"rigid bodies inside instances cannot be moved: {listed(found.instanced_bodies)}. Apply RigidBodyAPI to "
            "the instance itself, or clear its instanceable flag."
        )
    if found.left_behind:
        warn_once(
            "as in PhysX, colliders of rigid bodies that are disabled are static, and stay where they are when a body "
            f"above them moves, though their prims go along: {listed(found.left_behind)}. Remove RigidBodyAPI from "
            "them to make them part of the body above."
        )
    if heavy := [str(prim.GetPath()) for prim, owner in found.colliders if owner is None and _has_mass(prim)]:
        warn_once(
            f"static colliders never move, so their mass has no effect: {listed(heavy)}. Apply RigidBodyAPI to what "
            "shall move, or remove the MassAPI."
        )
    if found.static_belts:
        warn_once(
            f"only surfaces of rigid bodies carry what touches them, as in PhysX, and these are none: "
            f"{listed(found.static_belts)}. Apply RigidBodyAPI with physics:kinematicEnabled."
        )
    warn_without_scene(found.without_scene)
    warn_several_scenes(found.scenes, found.bodies)


def _has_mass(prim: Usd.Prim) -> bool:
    """Return whether a static collider has a mass, other than for when a body at or above it is enabled again."""
    if not has_api(prim, MASS) or not any(value(prim, f"physics:{name}", 0.0) for name in ("mass", "density")):
        return False
    return not any(has_api(prim.GetStage().GetPrimAtPath(path), RIGID_BODY) for path in prim.GetPath().GetPrefixes())


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
