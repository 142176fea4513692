"""Warn of prims that physics leaves out, or does not simulate as authored."""

from collections.abc import Collection, Mapping

from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import MASS, RIGID_BODY, has_api, value
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.physics_prims import LARGEST, PhysicsPrims
from usdsdg_physics.parse.simulation_owners import warn_several_scenes, warn_without_scene
from usdsdg_physics.scene.records import Body, Collider


def warn_unsupported(found: PhysicsPrims) -> None:
    """Warn of what will not be simulated, or not as authored, each once and with its remedy."""
    found.unread.warn()
    _warn_left_out(found)


def warn_no_collider(bodies: Mapping[str, Body], colliders: Collection[Collider]) -> None:
    """Warn of the bodies that own no collider; a trigger is enough for those that are kinematic, and do not fall."""
    solid, all_owners = ({each.body for each in colliders if keep or not each.trigger} for keep in (False, True))
    for path, body in bodies.items():
        if path not in (all_owners if body.kinematic else solid):
            follows = "nothing meets it" if body.kinematic else "it falls through everything"
            warn_once(
                f"{path} has RigidBodyAPI but no collider below it, so {follows}. Apply "
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


def _warn_left_out(found: PhysicsPrims) -> None:
    if found.nonfinite:
        warn_once(
            "these have a transform that is not a number, has an op of another type than its name says, or a number "
            f"above {LARGEST:g}, and are not simulated: {listed(found.nonfinite)}. Author a finite translation, "
            "rotation and scale on them and above them."
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
