"""Mass, center of mass and inertia of a body from its colliders and its MassAPI."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import permutations

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.stage.physics.instances import whole
from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.parse.shapes.convex_hulls import inertia_from_covariance
from usdsdg_physics.scene.records import Body, Collider, MassSpec, Shape
from usdsdg_physics.scene.triangles import is_closed
from usdsdg_physics.scene.volume_integrals import of_primitive

DEFAULT_DENSITY = 1000.0  # kg/m³, that of water, as in PhysX
# kg; the solver's regularization lets what weighs ten times as much sink millimeters into a floor, and what weighs a
# hundred times as much fall through it.
MOST_MASS = 1e8
# Of moments: more would be lost in single precision, which inverts the inertia.
LARGEST_RATIO = 1e4


@dataclass(frozen=True)
class MassProperties:
    """Mass properties of a body or of one of its colliders."""

    mass: float  # kg
    center: np.ndarray  # (3,) m, body frame
    inertia: np.ndarray  # (3, 3) kg m² about the center of mass, axes of the body frame


def body_mass(body: Body, colliders: Sequence[Collider]) -> MassProperties:
    """Return the mass properties of a body from its colliders, its own density, mass and inertia overriding theirs.

    Disabled colliders count too: switching a collider off does not make a body lighter. Triggers do not, and neither do
    triangle meshes that are not closed. A body without any that count has 1 kg unless its MassAPI says otherwise. More
    than `MOST_MASS` counts as that, with a warning. As in PhysX, a body does not turn about a principal axis whose
    moment is authored as 0 where others are not.
    The arrays are read-only.
    """
    found = _mass_of(body.mass, tuple(colliders))
    moments = body.mass.diagonal_inertia
    if moments is not None and not all(moments) and not body.kinematic:
        warn_once(
            f"{body.path}: physics:diagonalInertia has zeros beside other numbers. As in PhysX, the body hardly turns "
            "about these axes. Set positive numbers, or three zeros for the inertia of its colliders."
        )
    if found.mass <= MOST_MASS:
        return found
    if not body.kinematic:
        warn_once(
            f"{body.path} has a mass of {found.mass:.3g} kg, with which the solver would let it sink through a floor, "
            f"so it counts as {MOST_MASS:.3g} kg. Check its size, its mass and density, and the stage's metersPerUnit."
        )
    share = MOST_MASS / found.mass
    return replace(found, mass=MOST_MASS, inertia=share * found.inertia)


@lru_cache(maxsize=8192)  # a scene is built again when something is added to it while it plays
def _mass_of(given: MassSpec, colliders: tuple[Collider, ...]) -> MassProperties:
    """Return the mass properties of a body with a MassAPI and colliders."""
    volumes: defaultdict[str, float] = defaultdict(float)
    for collider in colliders:
        if collider.parts > 1:
            volumes[whole(collider.path)] += volume_integrals(collider.shape)[0]
    parts = [
        _collider_mass(collider, given.density, volumes.get(whole(collider.path)))
        for collider in colliders
        if not collider.trigger
    ]
    mass = sum(part.mass for part in parts)
    if mass <= 0.0:
        mass = given.mass or 1.0
        parts = [MassProperties(mass, np.zeros(3), 0.4 * mass * 0.1**2 * np.eye(3))]
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    if given.center_of_mass is not None:
        center = np.asarray(given.center_of_mass)
    inertia = sum((_inertia_about(part, center) for part in parts), np.zeros((3, 3)))
    if given.mass > 0.0:
        inertia, mass = inertia * (given.mass / mass), given.mass
    if given.diagonal_inertia is not None:
        inertia = _given_inertia(replace(given, diagonal_inertia=_without_zeros(given.diagonal_inertia)))
    elif given.has_axes:
        # As in PhysX: the moments are those of the colliders, the axes are not.
        axes = matrix_from_quat(given.principal_axes)
        inertia = axes.T @ np.diag(_principal_moments(inertia)) @ axes
    inertia = _invertible(inertia, mass)
    center.flags.writeable = inertia.flags.writeable = False
    return MassProperties(mass, center, inertia)


def _collider_mass(collider: Collider, body_density: float, total_volume: float | None) -> MassProperties:
    """Return the mass properties of a collider; `total_volume` is that of all convex parts of its prim if it is one."""
    volume, center, covariance = volume_integrals(collider.shape)
    density = collider.mass.density or body_density or collider.material.density or DEFAULT_DENSITY
    share = volume / total_volume if total_volume else 1.0
    mass = collider.mass.mass * share or density * volume
    if volume <= 0.0:
        return MassProperties(0.0, center, np.zeros((3, 3)))
    central = covariance - volume * np.outer(center, center)
    found, given = MassProperties(mass, center, inertia_from_covariance(central) * (mass / volume)), collider.mass
    if given.center_of_mass is not None:
        # Of what is not given PhysX takes the inertia of the shape about that center.
        center = np.asarray(given.center_of_mass)
        found = MassProperties(mass, center, _inertia_about(found, center))
    if given.diagonal_inertia is not None:
        found = replace(found, inertia=_given_inertia(given) * share)
    return found


def _given_inertia(given: MassSpec) -> np.ndarray:
    axes = matrix_from_quat(given.principal_axes)
    return axes.T @ np.diag(given.diagonal_inertia or (0.0, 0.0, 0.0)) @ axes


def _without_zeros(moments: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the principal moments of a body in which zeros are `LARGEST_RATIO` times the least of the others."""
    most = LARGEST_RATIO * min(moment for moment in moments if moment)
    x, y, z = (moment or most for moment in moments)
    return x, y, z


def _principal_moments(inertia: np.ndarray) -> np.ndarray:
    """Return the principal moments (3,), each in the place of the axis that its principal axis is nearest to."""
    moments, axes = np.linalg.eigh(inertia)
    order = max(
        permutations(range(3)), key=lambda order: sum(axes[row, column] ** 2 for row, column in enumerate(order))
    )
    return moments[list(order)]


def volume_integrals(shape: Shape) -> tuple[float, np.ndarray, np.ndarray]:
    """Return volume, centroid and integral of p pᵀ of a shape in its body's frame."""
    volume, center, covariance = _local_integrals(shape)
    rotation = matrix_from_quat(shape.rotation)
    position = np.asarray(shape.position)
    rotated = center @ rotation
    central = rotation.T @ (covariance - volume * np.outer(center, center)) @ rotation
    centroid = rotated + position
    return volume, centroid, central + volume * np.outer(centroid, centroid)


def _local_integrals(shape: Shape) -> tuple[float, np.ndarray, np.ndarray]:
    if shape.kind in ("hull", "mesh"):
        assert shape.solid is not None
        if shape.kind == "mesh" and not is_closed(shape.solid.triangles):
            return 0.0, np.zeros(3), np.zeros((3, 3))
        scale = np.asarray(shape.size)
        # Faces that look inward enclose the same solid.
        volume_scale = float(np.copysign(scale.prod(), shape.solid.volume))
        return (
            shape.solid.volume * volume_scale,
            shape.solid.centroid * scale,
            shape.solid.covariance * np.outer(scale, scale) * volume_scale,
        )
    return of_primitive(shape.kind, shape.size)


def _inertia_about(part: MassProperties, center: np.ndarray) -> np.ndarray:
    offset = part.center - center
    return part.inertia + part.mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))


def _invertible(inertia: np.ndarray, mass: float) -> np.ndarray:
    """Raise principal moments of which the largest is more than `LARGEST_RATIO` times as large."""
    moments, axes = np.linalg.eigh((inertia + inertia.T) / 2.0)
    floor = max(float(moments.max()) / LARGEST_RATIO, 1e-9 * mass, 1e-12)
    return (axes * np.maximum(moments, floor)) @ axes.T
