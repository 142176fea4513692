"""`isaacsim.core.utils.types`: records of states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class XFormPrimState:
    """The pose of one prim: position (3,) and orientation (4,), w, x, y, z."""

    position: np.ndarray
    orientation: np.ndarray


@dataclass
class XFormPrimViewState:
    """The poses of prims: positions (N, 3) and orientations (N, 4), w, x, y, z."""

    positions: np.ndarray
    orientations: np.ndarray


@dataclass
class DynamicState:
    """Pose and velocities of one body: position (3,), orientation (4,), linear and angular velocity (3,)."""

    position: np.ndarray
    orientation: np.ndarray
    linear_velocity: np.ndarray
    angular_velocity: np.ndarray


@dataclass
class DynamicsViewState:
    """Poses and velocities of bodies, one row each."""

    positions: np.ndarray
    orientations: np.ndarray
    linear_velocities: np.ndarray
    angular_velocities: np.ndarray
