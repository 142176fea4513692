"""UsdPhysics on a stage → records in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.errors import warn_once
from usdsdg_physics.parse.attributes import MASS, authored, finite, has_api, value
from usdsdg_physics.parse.collision_filters import read_filtered_pairs
from usdsdg_physics.parse.collision_shapes import read_shape
from usdsdg_physics.parse.convex_hulls import HullCache
from usdsdg_physics.parse.physics_prims import survey, warn_no_collider, warn_unsupported
from usdsdg_physics.scene.records import STATIC, Body, Collider, MassSpec, Material, Scene, Vec3
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose

GRAVITY = 9.81
# PhysX's contact offset when a collider names none is a few centimetres at human scale.
DEFAULT_GAP = 0.02


@dataclass(frozen=True)
class Units:
    """Factors from stage units to SI."""

    meters: float
    kilograms: float

    @classmethod
    def of(cls, stage: Usd.Stage) -> Units:
        return cls(float(UsdGeom.GetStageMetersPerUnit(stage)), float(UsdPhysics.GetStageKilogramsPerUnit(stage)))

    @property
    def density(self) -> float:
        return self.kilograms / self.meters**3

    @property
    def inertia(self) -> float:
        return self.kilograms * self.meters**2


def parse(stage: Usd.Stage, hulls: HullCache, *, root: Sdf.Path = Sdf.Path.absoluteRootPath) -> Scene:
    """Every rigid body and collider at or below `root`, instance proxies included.

    Joints, articulations, point-instanced bodies, bodies inside instances and whatever has a transform that is not a
    number are named in warnings and left out.
    """
    units = Units.of(stage)
    cache = UsdGeom.XformCache(Usd.TimeCode.Default())
    found = survey(stage, root, cache)
    warn_unsupported(found)
    scene_prim = found.scenes[0] if found.scenes else None
    bodies = {str(prim.GetPath()): read_body(prim, cache, units) for prim in found.bodies}
    materials = _bound_materials([prim for prim, _ in found.colliders], units)
    colliders = {}
    for (prim, owner), material in zip(found.colliders, materials):
        collider = read_collider(prim, owner, material, cache, units, hulls)
        if collider is not None:
            colliders[collider.path] = collider
    warn_no_collider(bodies, {collider.body for collider in colliders.values()})
    return Scene(
        bodies=bodies,
        colliders=colliders,
        gravity=read_gravity(stage, scene_prim, units),
        scene_path=str(scene_prim.GetPath()) if scene_prim else "",
        filtered=read_filtered_pairs(stage, colliders, found.filters, found.groups),
    )


def read_body(prim: Usd.Prim, cache: UsdGeom.XformCache, units: Units) -> Body:
    """A prim with RigidBodyAPI; its velocities are world vectors, the linear one of the centre of mass, as in PhysX."""
    local_to_world = np.array(cache.GetLocalToWorldTransform(prim))
    to_frame = body_from_prim(local_to_world, units.meters)
    max_angular = authored(prim, "physxRigidBody:maxAngularVelocity")
    return Body(
        path=str(prim.GetPath()),
        pose=tuple(rigid_pose(local_to_world, units.meters).tolist()),
        body_from_prim=tuple(tuple(row) for row in to_frame.tolist()),
        velocity=read_velocity(prim, units),
        angular_velocity=read_angular_velocity(prim),
        kinematic=bool(value(prim, "physics:kinematicEnabled", False)),
        gravity=not value(prim, "physxRigidBody:disableGravity", False),
        linear_damping=max(0.0, finite(value(prim, "physxRigidBody:linearDamping", 0.0), 0.0)),
        angular_damping=max(0.0, finite(value(prim, "physxRigidBody:angularDamping", 0.05), 0.05)),
        max_velocity=_limit(authored(prim, "physxRigidBody:maxLinearVelocity"), units.meters, float("inf")),
        max_angular_velocity=_limit(max_angular, np.pi / 180.0, 100.0),
        max_depenetration_velocity=_limit(authored(prim, "physxRigidBody:maxDepenetrationVelocity"), units.meters, 3.0),
        sleep_threshold=_sleep_threshold(prim, units),
        starts_asleep=bool(value(prim, "physics:startsAsleep", False)),
        mass=read_mass(prim, units, to_frame),
    )


def read_velocity(prim: Usd.Prim, units: Units) -> Vec3:
    """physics:velocity in m/s."""
    return _vector(value(prim, "physics:velocity", (0.0, 0.0, 0.0)), units.meters)


def read_angular_velocity(prim: Usd.Prim) -> Vec3:
    """physics:angularVelocity (degrees per second) in rad/s."""
    return _vector(value(prim, "physics:angularVelocity", (0.0, 0.0, 0.0)), np.pi / 180.0)


def read_collider(
    prim: Usd.Prim,
    owner: Usd.Prim | None,
    material: Material,
    cache: UsdGeom.XformCache,
    units: Units,
    hulls: HullCache,
) -> Collider | None:
    """A prim with CollisionAPI in the frame of the body that owns it, or in the world; None when it has no shape."""
    to_frame = frame_from_prim(prim, owner, cache, units)
    shape = read_shape(prim, to_frame, hulls, dynamic=owner is not None)
    if shape is None:
        return None
    margin = finite(authored(prim, "physxCollision:restOffset"), 0.0) * units.meters
    offset = finite(authored(prim, "physxCollision:contactOffset"), -1.0) * units.meters
    return Collider(
        path=str(prim.GetPath()),
        body=str(owner.GetPath()) if owner else STATIC,
        shape=shape,
        material=material,
        enabled=bool(value(prim, "physics:collisionEnabled", True)),
        gap=max(offset - margin, 0.0) if offset >= 0.0 else DEFAULT_GAP,
        margin=margin,
        mass=read_mass(prim, units, to_frame) if prim != owner else MassSpec(),
    )


def frame_from_prim(prim: Usd.Prim, owner: Usd.Prim | None, cache: UsdGeom.XformCache, units: Units) -> np.ndarray:
    """Row-vector 4x4 from a collider's space [stage units] to its body's frame, or the world, in metres."""
    if owner is None:
        matrix = np.array(cache.GetLocalToWorldTransform(prim))
        matrix[:, :3] *= units.meters
        return matrix
    # Local transforms up to the body, so that where the body stands does not round into its shapes.
    relative = np.eye(4) if prim == owner else np.array(cache.ComputeRelativeTransform(prim, owner)[0])
    return relative @ body_from_prim(np.array(cache.GetLocalToWorldTransform(owner)), units.meters)


def read_mass(prim: Usd.Prim, units: Units, to_frame: np.ndarray) -> MassSpec:
    """The MassAPI of a body or collider; `to_frame` takes its centre of mass from the prim's space to the frame."""
    if not has_api(prim, MASS):
        return MassSpec()
    center = authored(prim, "physics:centerOfMass")
    inertia = authored(prim, "physics:diagonalInertia")
    axes = authored(prim, "physics:principalAxes")
    # -inf is the schema's way to say "not given".
    given = center is not None and np.isfinite(center).all()
    return MassSpec(
        mass=max(0.0, finite(value(prim, "physics:mass", 0.0), 0.0)) * units.kilograms,
        density=max(0.0, finite(value(prim, "physics:density", 0.0), 0.0)) * units.density,
        center_of_mass=tuple((np.append(center, 1.0) @ to_frame)[:3].tolist()) if given else None,
        diagonal_inertia=_vector(inertia, units.inertia) if inertia is not None and any(inertia) else None,
        principal_axes=(*axes.GetImaginary(), axes.GetReal())
        if axes and axes.GetLength() > 0
        else (0.0, 0.0, 0.0, 1.0),
    )


def read_gravity(stage: Usd.Stage, scene: Usd.Prim | None, units: Units) -> Vec3:
    """Gravity [m/s²]: the PhysicsScene's, or 9.81 against the stage's up axis."""
    down = np.zeros(3)
    down["XYZ".index(str(UsdGeom.GetStageUpAxis(stage)))] = -1.0
    if scene is None:
        return _vector(down, GRAVITY)
    direction = np.asarray(value(scene, "physics:gravityDirection", (0.0, 0.0, 0.0)), np.float64)
    magnitude = value(scene, "physics:gravityMagnitude", -1.0)
    length = np.linalg.norm(direction)
    magnitude = GRAVITY if not np.isfinite(magnitude) or magnitude < 0 else float(magnitude) * units.meters
    return _vector(direction / length if length > 0 else down, magnitude)


def bound_material(prim: Usd.Prim, units: Units) -> Material:
    """The physics material that a prim has, its own or an ancestor's; PhysX's defaults when there is none."""
    return _bound_materials([prim], units)[0]


def _bound_materials(prims: list[Usd.Prim], units: Units) -> list[Material]:
    if not prims:
        return []
    bound, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, "physics")
    known: dict[Sdf.Path, Material] = {}
    materials = []
    for material in bound:
        prim = material.GetPrim()
        if not prim or not has_api(prim, "PhysicsMaterialAPI"):
            materials.append(Material())
            continue
        if prim.GetPath() not in known:
            known[prim.GetPath()] = _read_material(prim, units)
        materials.append(known[prim.GetPath()])
    return materials


def _read_material(prim: Usd.Prim, units: Units) -> Material:
    static = float(value(prim, "physics:staticFriction", 0.0))
    sliding = float(value(prim, "physics:dynamicFriction", 0.0))
    if abs(static - sliding) > 0.01:
        warn_once(
            f"{prim.GetPath()}: the solver has one friction coefficient; dynamicFriction {sliding:g} is used and "
            f"staticFriction {static:g} is not. Give both the same value.",
        )
    for name in ("frictionCombineMode", "restitutionCombineMode"):
        mode = str(value(prim, f"physxMaterial:{name}", "average"))
        if mode != "average":
            warn_once(f"{prim.GetPath()}: {name} {mode!r} is not supported, coefficients are averaged; use 'average'.")
    return Material(
        path=str(prim.GetPath()),
        friction=max(0.0, sliding),
        restitution=min(1.0, max(0.0, float(value(prim, "physics:restitution", 0.0)))),
        density=max(0.0, float(value(prim, "physics:density", 0.0))) * units.density,
    )


def _sleep_threshold(prim: Usd.Prim, units: Units) -> float:
    threshold = authored(prim, "physxRigidBody:sleepThreshold")
    return max(0.0, finite(threshold, 0.0)) * units.meters**2 if threshold is not None else 5e-5


def _limit(number: float | None, unit: float, default: float) -> float:
    return default if number is None or not np.isfinite(number) or number <= 0 else float(number) * unit


def _vector(components: object, factor: float) -> Vec3:
    x, y, z = (float(component) * factor for component in components)
    return x, y, z
