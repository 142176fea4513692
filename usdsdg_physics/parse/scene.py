"""Read UsdPhysics from a stage into a `Scene` of plain records in SI units."""

from collections.abc import Collection, Mapping

import numpy as np
from pxr import Sdf, Usd

from usdsdg.errors import warn_once
from usdsdg.stage.physics.scenes import EARTH_GRAVITY, simulated_scene
from usdsdg.stage.poses.transforms import up_axis
from usdsdg.stage.time_code import time_context
from usdsdg_physics.parse.attributes import finite, value
from usdsdg_physics.parse.bodies import read_body
from usdsdg_physics.parse.body_transforms import BodyXformCache
from usdsdg_physics.parse.colliders import read_collider, read_moving_collider
from usdsdg_physics.parse.collision_filters import read_filtered_pairs
from usdsdg_physics.parse.contact_reports import read_contact_report
from usdsdg_physics.parse.forces import read_force
from usdsdg_physics.parse.joints.jointed_bodies import (
    hold_unsupported,
    mark_articulated,
    read_jointed_pairs,
    read_joints,
)
from usdsdg_physics.parse.left_out import warn_filled, warn_no_collider, warn_unsupported
from usdsdg_physics.parse.materials import bound_materials, default_material, warn_unbound
from usdsdg_physics.parse.name_lists import listed
from usdsdg_physics.parse.physics_prims import find_physics_prims
from usdsdg_physics.parse.point_instancers import prototype_paths, read_instances
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.parse.units import Units, scaled_vector
from usdsdg_physics.scene.records import Body, Material, Scene, Vec3
from usdsdg_physics.scene.rigid_frames import split_together

FAR = 2.0**14  # m from the origin, from which on neighboring numbers of 32 bits are 2 mm apart
_DEFAULT_TIME = Usd.TimeCode.Default()


def parse(
    stage: Usd.Stage,
    hulls: HullCache,
    *,
    root: Sdf.Path = Sdf.Path.absoluteRootPath,
    time: Usd.TimeCode = _DEFAULT_TIME,
    broken: Collection[str] = (),
    default: Material | None = None,
) -> Scene:
    """Read every rigid body, collider and joint at or below `root`, instance proxies included.

    Bodies with a joint that cannot be simulated are kinematic. Bodies inside instances and prims whose transform is not
    finite are named in warnings and left out. Everything is as it is at `time`, but for what steps write of dynamic
    bodies: of that the default values count where there are any. Static colliders that time samples move become
    kinematic bodies. Joints at paths in `broken` are left out. `default` is the material of colliders without one;
    None: that of the PhysicsScene below `root`.
    """
    with time_context(time):
        return _parse(stage, hulls, root, broken, default)


def _parse(
    stage: Usd.Stage, hulls: HullCache, root: Sdf.Path, broken: Collection[str], default: Material | None
) -> Scene:
    units = Units.of(stage)
    found = find_physics_prims(stage, root)
    warn_unsupported(found)
    scene_prim = simulated_scene(found.scenes)
    animated, cache = {prim.GetPath() for prim in found.animated}, BodyXformCache(found.sampled)
    split_together([cache.GetLocalToWorldTransform(prim) for prim in found.bodies], units.meters)
    bodies = {str(prim.GetPath()): read_body(prim, cache, units) for prim in found.bodies}
    _warn_far(bodies)
    joints = read_joints(found, cache, units, broken)
    if root == Sdf.Path.absoluteRootPath:
        bodies, joints = hold_unsupported(found, bodies, joints)
        joints = mark_articulated(found, bodies, joints)
    default = default_material(scene_prim, units) if default is None else default
    materials = bound_materials([prim for prim, _ in found.colliders], units, default)
    colliders = {}
    for (prim, owner), material in zip(found.colliders, materials):
        if owner is None and prim.GetPath() in animated:
            body, read = read_moving_collider(prim, material, cache, units, hulls)
            bodies |= {body.path: body} if read else {}
        else:
            read = read_collider(prim, owner, material, cache, units, hulls)
        colliders |= {collider.path: collider for collider in read}
    for instances in (read_instances(prim, cache, units, hulls, default) for prim in found.instancers):
        bodies |= instances.bodies
        colliders |= instances.colliders
    warn_filled(hulls.take_filled())
    warn_no_collider(bodies, colliders.values())
    if root == Sdf.Path.absoluteRootPath:
        warn_unbound(found.loose_materials, (collider.material for collider in colliders.values()))
    forces = [read_force(prim, owner, cache, units) for prim, owner in found.forces]
    return Scene(
        bodies=bodies,
        colliders=colliders,
        gravity=read_gravity(stage, scene_prim, units),
        scene_path=str(scene_prim.GetPath()) if scene_prim else "",
        bounce_threshold=_bounce_threshold(scene_prim, units),
        default_material=default,
        filtered=read_filtered_pairs(
            colliders,
            found.filtered,
            found.groups,
            inverted=scene_prim is not None and bool(value(scene_prim, "physxScene:invertCollisionGroupFilter", False)),
        )
        | read_jointed_pairs(found, bodies, colliders, joints),
        joints=joints,
        animated=tuple(str(prim.GetPath()) for prim in found.animated if str(prim.GetPath()) in bodies),
        instancers=tuple(str(prim.GetPath()) for prim in found.instancers),
        prototypes=tuple(map(str, prototype_paths(found.instancers))),
        reports={str(prim.GetPath()): read_contact_report(prim, units) for prim in found.reports},
        has_relations=bool(found.joints or found.groups or found.filtered),
        relations=tuple(
            str(prim.GetPath()) for prim in (*found.joints, *found.groups, *found.filtered, *found.articulations)
        ),
        forces={force.path: force for force in forces if force is not None},
    )


def _bounce_threshold(scene: Usd.Prim | None, units: Units) -> float:
    """Return the speed [m/s] from which contacts bounce, of which the schema's 0 asks for the usual one."""
    speed = finite(value(scene, "physxScene:bounceThreshold", 0.0), 0.0) if scene is not None else 0.0
    return speed * units.meters if speed > 0.0 else Scene.bounce_threshold


def _warn_far(bodies: Mapping[str, Body]) -> None:
    """Warn of bodies so far from the origin that rounding moves them by millimeters."""
    reach = {path: max(map(abs, body.pose[:3])) for path, body in bodies.items()}
    if far := [path for path, distance in reach.items() if distance > FAR]:
        most = max(reach[path] for path in far)
        warn_once(
            f"positions have 32 bits here, as in PhysX: up to {most:.3g} m from the origin they are multiples of "
            f"{1e3 * np.spacing(np.float32(most)):.2g} mm, so bodies there move in jumps: {listed(far)}. Move "
            "the stage's content to the origin."
        )


def read_gravity(stage: Usd.Stage, scene: Usd.Prim | None, units: Units) -> Vec3:
    """Return gravity [m/s²]: the PhysicsScene's, or 9.81 against the stage's up axis."""
    down = np.zeros(3)
    down["XYZ".index(up_axis(stage))] = -1.0
    if scene is None:
        return scaled_vector(down, EARTH_GRAVITY)
    direction = np.asarray(value(scene, "physics:gravityDirection", (0.0, 0.0, 0.0)), np.float64)
    magnitude = value(scene, "physics:gravityMagnitude", -1.0)
    if not np.isfinite(direction).all():
        warn_once(
            f"{scene.GetPath()}: physics:gravityDirection is {tuple(direction.tolist())}, so down is "
            "that of the stage. Author finite numbers."
        )
        direction = np.zeros(3)
    if np.isnan(magnitude) or magnitude == np.inf:  # that of the schema is -inf
        warn_once(
            f"{scene.GetPath()}: physics:gravityMagnitude is {magnitude}, so {EARTH_GRAVITY:g} m/s² is used. "
            "Author a number."
        )
    elif -np.inf < magnitude < 0.0:
        warn_once(
            f"{scene.GetPath()}: physics:gravityMagnitude is {magnitude:g}, and numbers below 0 stand for that of the "
            f"Earth, {EARTH_GRAVITY:g} m/s². Author physics:gravityDirection to turn gravity around."
        )
    length = np.linalg.norm(direction)
    magnitude = EARTH_GRAVITY if not np.isfinite(magnitude) or magnitude < 0 else float(magnitude) * units.meters
    return scaled_vector(direction / length if length > 0 else down, magnitude)
