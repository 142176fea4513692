"""Jacobians, mass matrices and joint forces of an articulation from the poses and masses of its links.

Everything is in the world and in stage units. Coordinates are the velocities of the joints; before them, of a base
that nothing fixes, the velocity of its center of mass and its angular velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Links:
    """The links of an articulation, the base first and parents before children."""

    center: Array  # (L, 3) centers of mass
    mass: Array  # (L,)
    inertia: Array  # (L, 3, 3) about the center of mass
    gravity: Array  # (L, 3) acceleration, zeros of links without gravity


@dataclass(frozen=True)
class Motion:
    """What one joint lets its link do: turn about an axis, slide along it, or neither."""

    parent: int  # row of the link that carries it
    link: int
    column: int = -1  # number of the joint among those with a position; -1 for none
    turns: bool = False
    axis: Array | None = None  # (3,) direction in which the link moves against its parent where the position grows
    anchor: Array | None = None  # (3,) a point of the axis


def jacobian(links: Links, motions: list[Motion], dofs: int, *, is_fixed: bool) -> Array:
    """Return (L, 6, C): velocity of each center of mass and angular velocity by coordinate; C is D, or 6 + D."""
    first = 0 if is_fixed else 6
    found = np.zeros((len(links.mass), 6, first + dofs))
    if not is_fixed:
        found[0, :, :6] = np.eye(6)
    for motion in motions:
        arm = links.center[motion.link] - links.center[motion.parent]
        found[motion.link] = found[motion.parent]
        found[motion.link, :3] += np.cross(found[motion.parent, 3:], arm, axis=0)
        if motion.column >= 0 and motion.axis is not None and motion.anchor is not None:
            column = first + motion.column
            if motion.turns:
                found[motion.link, 3:, column] += motion.axis
                found[motion.link, :3, column] += np.cross(motion.axis, links.center[motion.link] - motion.anchor)
            else:
                found[motion.link, :3, column] += motion.axis
    return found


def mass_matrix(links: Links, moved: Array, armature: Array) -> Array:
    """Return (C, C) for a Jacobian `moved` and the armature (D,) of joints."""
    linear, angular = moved[:, :3], moved[:, 3:]
    found = np.einsum("l,lic,lid->cd", links.mass, linear, linear)
    found += np.einsum("lic,lij,ljd->cd", angular, links.inertia, angular)
    first = len(found) - len(armature)
    found[range(first, len(found)), range(first, len(found))] += armature
    return found


def gravity_forces(links: Links, moved: Array) -> Array:
    """Return the forces and torques (C,) that hold the articulation against gravity."""
    return -np.einsum("l,li,lic->c", links.mass, links.gravity, moved[:, :3])


def coriolis_forces(links: Links, motions: list[Motion], moved: Array, velocities: Array, *, is_fixed: bool) -> Array:
    """Return the forces and torques (C,) that keep the coordinates' `velocities` (C,) as they are, without gravity."""
    first = 0 if is_fixed else 6
    speed = moved @ velocities  # (L, 6)
    linear, angular = np.zeros((len(links.mass), 3)), np.zeros((len(links.mass), 3))
    for motion in motions:
        turn = speed[motion.parent, 3:]
        rate = np.zeros(3)
        if motion.column >= 0 and motion.axis is not None:
            rate = motion.axis * velocities[first + motion.column]
        through = links.center[motion.link] if motion.anchor is None or not motion.turns else motion.anchor
        arm, rest = through - links.center[motion.parent], links.center[motion.link] - through
        linear[motion.link] = linear[motion.parent] + _carried(angular[motion.parent], turn, arm)
        if motion.turns:
            angular[motion.link] = angular[motion.parent] + np.cross(turn, rate)
            linear[motion.link] += _carried(angular[motion.link], speed[motion.link, 3:], rest)
        else:
            angular[motion.link] = angular[motion.parent]
            linear[motion.link] += 2.0 * np.cross(turn, rate)
    turned = np.einsum("lij,lj->li", links.inertia, speed[:, 3:])
    torque = np.einsum("lij,lj->li", links.inertia, angular) + np.cross(speed[:, 3:], turned)
    force = links.mass[:, None] * linear
    return np.einsum("li,lic->c", force, moved[:, :3]) + np.einsum("li,lic->c", torque, moved[:, 3:])


def _carried(acceleration: Array, velocity: Array, arm: Array) -> Array:
    """Return by how much a point at an `arm` of a turning body accelerates more than the arm's beginning."""
    return np.cross(acceleration, arm) + np.cross(velocity, np.cross(velocity, arm))
