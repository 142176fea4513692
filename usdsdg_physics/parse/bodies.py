"""Read rigid bodies and mass properties: RigidBodyAPI, PhysxRigidBodyAPI, MassAPI."""

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.errors import warn_once
from usdsdg.stage.physics.joints import ARTICULATION_ROOT
from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg_physics.parse.attributes import (
    MASS,
    SURFACE_VELOCITY,
    authored,
    finite,
    has_api,
    positive,
    value,
    written_value,
)
from usdsdg_physics.parse.units import Units, scaled_vector
from usdsdg_physics.scene.records import Body, MassSpec, SurfaceVelocity, Vec3
from usdsdg_physics.scene.rigid_frames import body_from_prim, rigid_pose

# m/s and rad/s; squares of more leave the range of numbers with 32 bits in the solver.
MOST_SPEED = 1e9
FARTHEST_CENTER = 1e6  # m


def read_body(prim: Usd.Prim, cache: UsdGeom.XformCache, units: Units) -> Body:
    """Read a prim with RigidBodyAPI.

    Its velocities are world vectors, the linear one of the center of mass, as in PhysX.
    """
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
        locked_position=int(value(prim, "physxRigidBody:lockedPosAxis", 0)) & 7,
        locked_rotation=int(value(prim, "physxRigidBody:lockedRotAxis", 0)) & 7,
        surface=read_surface_velocity(prim, to_frame, units),
        continuous=bool(value(prim, "physxRigidBody:enableCCD", False)),
        is_articulation_root=has_api(prim, ARTICULATION_ROOT)
        and bool(value(prim, "physxArticulation:articulationEnabled", True)),
    )


def read_velocity(prim: Usd.Prim, units: Units) -> Vec3:
    """Read physics:velocity in m/s."""
    return scaled_vector(_velocity(prim, "physics:velocity", MOST_SPEED / units.meters), units.meters)


def read_angular_velocity(prim: Usd.Prim) -> Vec3:
    """Read physics:angularVelocity (degrees per second) in rad/s."""
    return scaled_vector(_velocity(prim, "physics:angularVelocity", np.degrees(MOST_SPEED)), np.pi / 180.0)


def _velocity(prim: Usd.Prim, name: str, most: float) -> Sequence[float]:
    """Return a velocity; zero, with a warning, of one that no body has."""
    found = written_value(prim, name, (0.0, 0.0, 0.0))
    if all(abs(component) <= most for component in found):
        return found
    warn_once(
        f"{prim.GetPath()}: {name} is {tuple(found)}, too large or not a number, so it counts as 0. Set numbers of at "
        f"most {most:.3g}."
    )
    return 0.0, 0.0, 0.0


def read_surface_velocity(prim: Usd.Prim, to_frame: np.ndarray, units: Units) -> SurfaceVelocity | None:
    """Read a PhysxSurfaceVelocityAPI; None where there is none, no velocity where it is disabled.

    A local velocity is scaled with the prim, as in PhysX; an angular one, in degrees per second, is not.
    """
    if not has_api(prim, SURFACE_VELOCITY):
        return None
    if not value(prim, "physxSurfaceVelocity:surfaceVelocityEnabled", True):
        return SurfaceVelocity((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    local = bool(value(prim, "physxSurfaceVelocity:surfaceVelocityLocalSpace", True))
    linear = np.asarray(value(prim, "physxSurfaceVelocity:surfaceVelocity", (0.0, 0.0, 0.0)), np.float64)
    angular = value(prim, "physxSurfaceVelocity:surfaceAngularVelocity", (0.0, 0.0, 0.0))
    return SurfaceVelocity(
        linear=scaled_vector(linear @ to_frame[:3, :3], 1.0) if local else scaled_vector(linear, units.meters),
        angular=scaled_vector(angular, np.pi / 180.0),
        local=local,
    )


def read_mass(prim: Usd.Prim, units: Units, to_frame: np.ndarray) -> MassSpec:
    """Read the MassAPI of a body or collider.

    Args:
        to_frame: row-vector 4x4 from the prim's space [stage units] to the body's frame [m].
    """
    if not has_api(prim, MASS):
        return MassSpec()
    center = authored(prim, "physics:centerOfMass")
    inertia = authored(prim, "physics:diagonalInertia")
    axes = authored(prim, "physics:principalAxes")
    # The schema's fallback for "not given" is -inf.
    if center is not None and not np.isfinite(center).all():
        center = None
    if center is not None and not max(abs(part) for part in center) * units.meters <= FARTHEST_CENTER:
        warn_once(
            f"{prim.GetPath()}: physics:centerOfMass is {tuple(center)}, so far away that it counts as not given. Set "
            "a point near the body."
        )
        center = None
    if inertia is not None and not all(0.0 <= moment < np.inf for moment in inertia):
        warn_once(
            f"{prim.GetPath()}: physics:diagonalInertia is {tuple(inertia)}, so it counts as not given. Set positive "
            "numbers, or zeros."
        )
        inertia = None
    if axes and not 0.0 < axes.GetLength() < np.inf:
        axes = None
    turned = compose(rotation=(*axes.GetImaginary(), axes.GetReal())) if axes else np.eye(4)
    turned = turned @ compose(rotation=decompose(to_frame).rotation)
    return MassSpec(
        mass=positive(prim, "physics:mass") * units.kilograms,
        density=positive(prim, "physics:density") * units.density,
        center_of_mass=tuple((np.append(center, 1.0) @ to_frame)[:3].tolist()) if center is not None else None,
        diagonal_inertia=scaled_vector(inertia, units.inertia) if inertia is not None and any(inertia) else None,
        principal_axes=tuple(decompose(turned).rotation.tolist()),
        has_axes=bool(axes),
    )


def _sleep_threshold(prim: Usd.Prim, units: Units) -> float:
    """Return the kinetic energy per mass [m²/s²] below which a body may come to rest."""
    threshold = authored(prim, "physxRigidBody:sleepThreshold")
    return max(0.0, finite(threshold, 0.0)) * units.meters**2 if threshold is not None else 5e-5


def _limit(number: float | None, unit: float, default: float) -> float:
    """Return a velocity limit in SI units; `default` where it is not a positive number."""
    return default if number is None or not np.isfinite(number) or number <= 0 else float(number) * unit
