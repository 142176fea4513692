"""What joints mean to the bodies of a scene: which are held, and which do not collide."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import replace
from itertools import combinations, product

from pxr import Sdf, Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.paths import at_or_below
from usdsdg_physics.parse.attributes import value
from usdsdg_physics.parse.joints.gears import couple, coupled_bodies, is_gear
from usdsdg_physics.parse.joints.joint_ends import joint_bodies
from usdsdg_physics.parse.joints.joint_types import is_supported
from usdsdg_physics.parse.joints.joints import read_joint
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.physics_prims import PhysicsPrims
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.joint_trees import connected_bodies, joint_trees, unsupported_loops
from usdsdg_physics.scene.records import STATIC, Body, Collider, Joint


def read_joints(
    found: PhysicsPrims, cache: UsdGeom.XformCache, units: Units, broken: Collection[str]
) -> dict[str, Joint]:
    """Read the joints that are enabled and not `broken`, by path."""
    enabled = (prim for prim in found.joints if is_supported(prim) and value(prim, "physics:jointEnabled", True))
    read = (read_joint(prim, cache, units) for prim in enabled if str(prim.GetPath()) not in broken)
    joints = {joint.path: joint for joint in read if joint is not None}
    return couple([prim for prim in found.joints if is_gear(prim)], joints, cache, units)


def hold_unsupported(
    found: PhysicsPrims, bodies: dict[str, Body], joints: dict[str, Joint]
) -> tuple[dict[str, Body], dict[str, Joint]]:
    """Make all bodies kinematic that a joint which cannot be simulated connects, and leave out their joints."""
    joints = {path: joint for path, joint in joints.items() if _has_bodies(joint, bodies)}
    # That their types have no effect is said with all other schemas that have none.
    others = {
        str(prim.GetPath()): joint_bodies(prim)
        for prim in found.joints
        if not (is_supported(prim) or is_gear(prim)) and value(prim, "physics:jointEnabled", True)
    }
    loops = unsupported_loops(joint_trees(bodies, joints.values()))
    if loops:
        warn_once(
            f"joints cannot close a loop between what two kinematic bodies carry: {listed([j.path for j in loops])}. "
            "Their bodies, and all that are jointed to them, stay where they are; make one of the kinematic bodies a "
            "static collider, or disable these joints (physics:jointEnabled)."
        )
    start = [path for paths in others.values() for path in paths]
    start += [path for joint in loops for path in (joint.body0, joint.body1)]
    held = connected_bodies(joints.values(), start, bodies)
    bodies = bodies | {path: replace(bodies[path], kinematic=True, held=True) for path in held}
    joints = {path: joint for path, joint in joints.items() if not {joint.body0, joint.body1} & held}
    return _unlocked(bodies, joints), joints


def _unlocked(bodies: dict[str, Body], joints: Mapping[str, Joint]) -> dict[str, Body]:
    """Unlock the axes of bodies that joints move."""
    jointed = {path for joint in joints.values() for path in (joint.body0, joint.body1)} & bodies.keys()
    locked = [
        path for path in bodies if path in jointed and (bodies[path].locked_position or bodies[path].locked_rotation)
    ]
    if locked:
        warn_once(
            f"lockedPosAxis and lockedRotAxis have no effect on bodies with joints: {listed(locked)}. Limit the axes "
            "of their joints."
        )
    return bodies | {path: replace(bodies[path], locked_position=0, locked_rotation=0) for path in locked}


def mark_articulated(found: PhysicsPrims, bodies: Mapping[str, Body], joints: Mapping[str, Joint]) -> dict[str, Joint]:
    """Return the joints, with those marked that PhysX makes joints of an articulation.

    These connect its bodies with each other and the world, whether below the prim with ArticulationRootAPI or not.
    """
    enabled = (prim for prim in found.articulations if value(prim, "physxArticulation:articulationEnabled", True))
    roots = [str(prim.GetPath()) for prim in enabled]
    if not roots:
        return _without_articulation(joints)
    kinematic = {path for path, body in bodies.items() if body.kinematic}
    links = [
        joint
        for joint in joints.values()
        if joint.in_articulation and joint.kind != "distance" and not {joint.body0, joint.body1} & kinematic
    ]
    start = [
        body
        for joint in links
        for body in (joint.body0, joint.body1)
        if any(at_or_below(path, root) for path in (joint.path, joint.body0, joint.body1) for root in roots)
    ]
    inside = connected_bodies(links, start, bodies)
    marked = {joint.path for joint in links if {joint.body0, joint.body1} & inside}
    unbroken = [path for path in sorted(marked) if joints[path].breaks]
    if unbroken:
        warn_once(
            "as in PhysX, physics:breakForce and physics:breakTorque have no effect on the joints of an articulation: "
            f"{listed(unbroken)}. Set physics:excludeFromArticulation on those that shall break."
        )
    return _without_articulation({path: replace(joint, articulated=path in marked) for path, joint in joints.items()})


def _without_articulation(joints: Mapping[str, Joint]) -> dict[str, Joint]:
    """Return the joints, of which those of no articulation neither rub nor resist nor have a highest speed."""
    bare = {"armature": 0.0, "friction": 0.0, "static_friction": 0.0, "damping": 0.0, "max_velocity": float("inf")}
    found, ignored = {}, []
    for path, joint in joints.items():
        axes = joint.axes if joint.articulated else tuple(replace(axis, **bare) for axis in joint.axes)
        found[path] = replace(joint, axes=axes)
        if axes != joint.axes:
            ignored.append(path)
    if ignored:
        warn_once(
            "as in PhysX, physxJoint:jointFriction, armature and maxJointVelocity and PhysxJointAxisAPI have no effect "
            f"on joints outside of articulations: {listed(sorted(ignored))}. Apply UsdPhysics.ArticulationRootAPI to "
            "one of their bodies or a prim above, or use a drive with damping and maxForce."
        )
    return found


def read_jointed_pairs(
    found: PhysicsPrims, bodies: Mapping[str, Body], colliders: Mapping[str, Collider], joints: Mapping[str, Joint]
) -> frozenset[tuple[str, str]]:
    """Return the pairs of colliders, each sorted, that joints keep from colliding.

    These are between the two bodies of a joint, a gear or a rack without collisionEnabled, and among all links of an
    articulation without self-collisions.
    """
    if not joints:
        return frozenset()
    owned: defaultdict[str, list[str]] = defaultdict(list)
    for collider in colliders.values():
        owned[collider.body].append(collider.path)
    pairs: set[tuple[str, str]] = set()
    for prim in found.joints:
        if value(prim, "physics:collisionEnabled", False):
            continue
        joint = joints.get(str(prim.GetPath()))
        if joint is not None:
            pairs |= set(product(_colliders(prim, 0, joint.body0, owned), _colliders(prim, 1, joint.body1, owned)))
        elif is_gear(prim) and value(prim, "physics:jointEnabled", True):
            first, second = (owned.get(body, []) for body in coupled_bodies(prim))
            pairs |= set(product(first, second))
    roots = [prim for prim in found.articulations if not value(prim, "physxArticulation:enabledSelfCollisions", True)]
    for tree in joint_trees(bodies, joints.values()) if roots else ():
        paths = [*tree.bodies, *(branch.joint.path for branch in tree.branches)]
        if any(at_or_below(path, str(root.GetPath())) for root in roots for path in paths):
            pairs |= set(combinations([path for body in tree.bodies for path in owned[body]], 2))
    return frozenset((min(pair), max(pair)) for pair in pairs if pair[0] != pair[1])


def _colliders(prim: Usd.Prim, number: int, body: str, owned: Mapping[str, list[str]]) -> list[str]:
    """Return the colliders at an end of a joint: those of its body, or of the static prim that it names."""
    if body != STATIC:
        return owned.get(body, [])
    relation = prim.GetRelationship(f"physics:body{number}")
    targets = relation.GetTargets() if relation else []
    return [path for path in owned.get(STATIC, []) if targets and Sdf.Path(path).HasPrefix(targets[0])]


def _has_bodies(joint: Joint, bodies: Mapping[str, Body]) -> bool:
    """Return whether both ends are bodies of the scene, or the world; one with a transform that is no number is not."""
    return all(path == STATIC or path in bodies for path in (joint.body0, joint.body1))
