"""Read the bodies and colliders that PointInstancers make of their prototypes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.errors import counted, warn_once
from usdsdg.stage.physics.instances import instance_name, part_name
from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg.stage.time_code import current_time, current_value
from usdsdg_physics.parse.attributes import COLLISION, RIGID_BODY, has_api, value
from usdsdg_physics.parse.bodies import read_body, read_mass, read_surface_velocity
from usdsdg_physics.parse.colliders import colliders_in_frame
from usdsdg_physics.parse.materials import bound_materials
from usdsdg_physics.parse.shapes.convex_hulls import HullCache
from usdsdg_physics.parse.simulation_owners import has_scene, warn_without_scene
from usdsdg_physics.parse.units import Units, scaled_vector
from usdsdg_physics.scene.records import STATIC, Body, Collider, Material, Shape
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose, rotation_quat, split_together


@dataclass
class Instances:
    """Bodies and colliders of one PointInstancer, by name."""

    bodies: dict[str, Body] = field(default_factory=dict)
    colliders: dict[str, Collider] = field(default_factory=dict)


@dataclass
class _Prototype:
    root: Usd.Prim
    is_body: bool
    colliders: list[tuple[Usd.Prim, str, Material]]  # with the path below the root
    # By the constant part of an instance's matrix: its body, and its colliders in the frame of the root.
    made: dict[bytes, tuple[Body | None, list[tuple[Collider, str]]]] = field(default_factory=dict)


def prototype_paths(instancers: Sequence[Usd.Prim]) -> list[Sdf.Path]:
    """Return the paths at and below which everything is part of a prototype: those of prototypes and instancers."""
    targets = (UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets() for prim in instancers)
    return [*(path for paths in targets for path in paths), *(prim.GetPath() for prim in instancers)]


def read_instances(
    prim: Usd.Prim, cache: UsdGeom.XformCache, units: Units, hulls: HullCache, default: Material
) -> Instances:
    """Read the instances of a PointInstancer; those that are inactive are left out.

    A rigid body is simulated where it is the root of its prototype. `default` is the material of colliders without one.
    """
    instancer, found = UsdGeom.PointInstancer(prim), Instances()
    prototypes = [_prototype(prim, path, units, default) for path in instancer.GetPrototypesRel().GetForwardedTargets()]
    if not any(map(_has_physics, prototypes)):
        return found  # grass and gravel that are only drawn may be millions
    time = current_time()
    indices = current_value(instancer.GetProtoIndicesAttr()) or ()
    matrices = instancer.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    if len(matrices) != len(indices):
        _warn_invalid(instancer)
        return found
    to_world = np.array(cache.GetLocalToWorldTransform(prim))
    velocities = _velocities(instancer, len(indices), to_world, units)
    inactive = _inactive(instancer, len(indices))
    worlds = np.asarray(matrices, np.float64).reshape(-1, 4, 4) @ to_world
    simulated = [
        (index, prototypes[kind])
        for index, kind in enumerate(indices)
        if 0 <= kind < len(prototypes) and _has_physics(prototypes[kind]) and index not in inactive
    ]
    split_together([worlds[index] for index, _ in simulated], units.meters)
    for index, prototype in simulated:
        if prototype is not None and np.isfinite(worlds[index]).all():
            _add(found, str(prim.GetPath()), index, prototype, worlds[index], velocities, cache, units, hulls)
    return found


def _has_physics(prototype: _Prototype | None) -> bool:
    return prototype is not None and (prototype.is_body or bool(prototype.colliders))


def _warn_invalid(instancer: UsdGeom.PointInstancer) -> None:
    """Say why USD computes no transforms of the instances."""
    path, indices = instancer.GetPath(), current_value(instancer.GetProtoIndicesAttr()) or ()
    positions = current_value(instancer.GetPositionsAttr()) or ()
    prototypes = len(instancer.GetPrototypesRel().GetForwardedTargets())
    if len(indices) == len(positions) and (wrong := [kind for kind in indices if not 0 <= kind < prototypes]):
        warn_once(
            f"{path} has the protoIndices {sorted(set(wrong))} and {counted(prototypes, 'prototype')}, so its "
            "instances are neither bodies nor colliders. Use indices of its prototypes."
        )
        return
    warn_once(
        f"{path} has {counted(len(indices), 'entry', 'entries')} in protoIndices and {len(positions)} in positions, so "
        "its instances are neither bodies nor colliders. Author as many of each."
    )


def _prototype(instancer: Usd.Prim, path: Sdf.Path, units: Units, default: Material) -> _Prototype | None:
    root = instancer.GetStage().GetPrimAtPath(path)
    if not root:
        return None
    is_body = has_api(root, RIGID_BODY) and bool(value(root, "physics:rigidBodyEnabled", True))
    if is_body and instancer.IsInstanceProxy():
        warn_once(
            f"rigid bodies of a PointInstancer inside an instance cannot be moved: {instancer.GetPath()}. Clear the "
            "instanceable flag of the instance."
        )
        is_body = False
    if is_body and not has_scene(root):
        warn_without_scene([str(path)])
        return None
    colliders, below = [], []
    predicate = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)
    for prim in Usd.PrimRange(root, predicate):
        if prim != root and has_api(prim, RIGID_BODY):
            below.append(str(prim.GetPath()))
        if prim.IsA(UsdGeom.PointInstancer):
            below.append(str(prim.GetPath()))
        if has_api(prim, COLLISION):
            colliders.append(prim)
    if below:
        warn_once(
            f"bodies and instancers below the root of a prototype of {instancer.GetPath()} do not move by themselves: "
            f"{', '.join(below[:5])}. Apply RigidBodyAPI to the prototype itself."
        )
    materials = bound_materials(colliders, units, default)
    suffixes = (str(prim.GetPath()).removeprefix(str(path)) for prim in colliders)
    return _Prototype(root, is_body, list(zip(colliders, suffixes, materials)))


def _add(
    found: Instances,
    instancer: str,
    index: int,
    prototype: _Prototype,
    world: np.ndarray,
    velocities: tuple[np.ndarray | None, np.ndarray | None],
    cache: UsdGeom.XformCache,
    units: Units,
    hulls: HullCache,
) -> None:
    """Add one instance, whose root has the matrix `world`."""
    pose, constant = rigid_pose(world, units.meters), body_from_prim(world, units.meters)
    # Rounding of the pose must not make another shape of each instance, and -0.0 is 0.0.
    size = max(float(np.abs(constant[:3, :3]).max()), 1e-30)
    key = (np.round(constant / size, 5) + 0.0).tobytes() + np.float32(size).tobytes()
    if key not in prototype.made:
        prototype.made[key] = _make(prototype, constant, cache, units, hulls)
    body, colliders = prototype.made[key]
    name = instance_name(instancer, index)
    if body is not None:
        linear, angular = velocities
        found.bodies[name] = replace(
            body,
            path=name,
            pose=tuple(pose.tolist()),
            velocity=body.velocity if linear is None else scaled_vector(linear[index], 1.0),
            angular_velocity=body.angular_velocity if angular is None else scaled_vector(angular[index], 1.0),
        )
    for collider, below in colliders:
        path = instance_name(instancer, index, below)
        shape = collider.shape if body is not None else _placed(collider.shape, pose)
        found.colliders[path] = replace(collider, path=path, body=name if body is not None else STATIC, shape=shape)


def _make(
    prototype: _Prototype, constant: np.ndarray, cache: UsdGeom.XformCache, units: Units, hulls: HullCache
) -> tuple[Body | None, list[tuple[Collider, str]]]:
    """Return the body and colliders of the instances of a prototype with this constant part of their matrices."""
    root, colliders = prototype.root, []
    for prim, below, material in prototype.colliders:
        relative = np.eye(4) if prim == root else np.array(cache.ComputeRelativeTransform(prim, root)[0])
        owner = root if prototype.is_body else None
        found = colliders_in_frame(prim, relative @ constant, material, units, hulls, owner=owner)
        colliders += [(collider, part_name(below, part)) for part, collider in enumerate(found)]
    if not prototype.is_body:
        return None, colliders
    body = replace(
        read_body(root, cache, units),
        body_from_prim=tuple(tuple(row) for row in constant.tolist()),
        mass=read_mass(root, units, constant),
        surface=read_surface_velocity(root, constant, units),
    )
    return body, colliders


def _placed(shape: Shape, pose: np.ndarray) -> Shape:
    """Return a shape in a frame with a pose (7,), in the world."""
    rotation = matrix_from_quat(pose[3:])
    x, y, z = (np.asarray(shape.position) @ rotation + pose[:3]).tolist()
    return replace(shape, position=(x, y, z), rotation=rotation_quat(matrix_from_quat(shape.rotation) @ rotation))


def _velocities(
    instancer: UsdGeom.PointInstancer, count: int, to_world: np.ndarray, units: Units
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return velocities [m/s] and angular velocities [rad/s] (n, 3) of the instances, world; None: none authored."""
    linear, angular = (
        np.asarray(current_value(attribute) or (), np.float64).reshape(-1, 3)
        for attribute in (instancer.GetVelocitiesAttr(), instancer.GetAngularVelocitiesAttr())
    )
    axes = to_world[:3, :3] / np.linalg.norm(to_world[:3, :3], axis=1, keepdims=True)
    return (
        linear @ to_world[:3, :3] * units.meters if len(linear) == count else None,
        # Where the instancer is mirrored, what turns one way in it turns the other way in the world.
        np.radians(angular) @ axes * np.sign(np.linalg.det(axes)) if len(angular) == count else None,
    )


def _inactive(instancer: UsdGeom.PointInstancer, count: int) -> set[int]:
    """Return the indices of instances whose ids are among the inactive ones."""
    listed = instancer.GetPrim().GetMetadata("inactiveIds")
    if listed is None:
        return set()
    inactive = set(listed.GetAppliedItems())
    ids = list(current_value(instancer.GetIdsAttr()) or range(count))
    return {index for index, identifier in enumerate(ids) if identifier in inactive}
