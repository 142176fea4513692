"""`isaacsim.core.utils.types`: records of states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

# Numbers of joints: an array, or a list in which None leaves a joint as it is.
JointNumbers: TypeAlias = np.ndarray | Sequence[float | None] | None


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


@dataclass
class JointsState:
    """Positions, velocities and efforts of joints, (D,) of one robot or (N, D) of several; None where not known."""

    positions: np.ndarray | None
    velocities: np.ndarray | None
    efforts: np.ndarray | None


class DataFrame:
    """What a data logger keeps of one step."""

    def __init__(self, current_time_step: int, current_time: float, data: dict[str, Any]) -> None:
        self.current_time_step, self.current_time, self.data = current_time_step, current_time, data

    def get_dict(self) -> dict[str, Any]:
        return {"current_time": self.current_time, "current_time_step": self.current_time_step, "data": self.data}

    def __str__(self) -> str:
        return str(self.get_dict())

    @classmethod
    def init_from_dict(cls, dict_representation: dict[str, Any]) -> DataFrame:
        """Return the frame whose `get_dict` this is."""
        return cls(**dict_representation)


class ArticulationAction:
    """Targets of one robot's drives and efforts of its joints: (K,) each, None for none.

    NaN, or None in a list, leaves a joint as it is.
    """

    def __init__(
        self,
        joint_positions: JointNumbers = None,
        joint_velocities: JointNumbers = None,
        joint_efforts: JointNumbers = None,
        joint_indices: np.ndarray | Sequence[int] | None = None,
    ) -> None:
        """Give targets and efforts of the joints `joint_indices` (K,), by default of all in order."""
        self.joint_positions, self.joint_velocities = joint_positions, joint_velocities
        self.joint_efforts, self.joint_indices = joint_efforts, joint_indices

    def get_dof_action(self, index: int) -> dict[str, float]:
        """Return the effort of one joint, or else its targets, under "effort", "velocity" and "position"."""
        if self.joint_efforts is not None and self.joint_efforts[index] is not None:
            return {"effort": self.joint_efforts[index]}  # pyright: ignore[reportReturnType]
        both = (("velocity", self.joint_velocities), ("position", self.joint_positions))
        return {name: row[index] for name, row in both if row is not None and row[index] is not None}  # pyright: ignore

    def get_dict(self) -> dict[str, Any]:
        """Return targets and efforts by name, arrays as lists."""
        return {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in list(vars(self).items())[:3]
        }

    def __str__(self) -> str:
        return str(self.get_dict())

    def get_length(self) -> int | None:
        """Return for how many joints there are targets or efforts; None without any."""
        given = (self.joint_positions, self.joint_velocities, self.joint_efforts)
        return max((len(each) for each in given if each is not None), default=None)


class ArticulationActions:
    """Targets of several robots' drives and efforts of their joints: (N, K) each, None for none."""

    def __init__(
        self,
        joint_positions: np.ndarray | None = None,
        joint_velocities: np.ndarray | None = None,
        joint_efforts: np.ndarray | None = None,
        joint_indices: np.ndarray | Sequence[int] | None = None,
        joint_names: Sequence[str] | None = None,
    ) -> None:
        """Give targets and efforts of the joints `joint_indices` or `joint_names` (K,), by default of all in order.

        Raises:
            ValueError: both indices and names are given.
        """
        if joint_names is not None and joint_indices is not None:
            raise ValueError("give either joint_indices or joint_names, not both")
        self.joint_positions, self.joint_velocities = joint_positions, joint_velocities
        self.joint_efforts, self.joint_indices, self.joint_names = joint_efforts, joint_indices, joint_names
