"""`BaseGripperController`: what a script derives the controllers of its grippers from."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from usdsdg.compat.isaacsim.core.api.controllers.base_controller import BaseController
from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction


class BaseGripperController(BaseController):
    """A controller that opens and closes."""

    def forward(self, action: str, current_joint_positions: np.ndarray) -> ArticulationAction:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Return what `open` or `close` returns, as `action` says.

        Raises:
            ValueError: it is neither.
        """
        if action not in ("open", "close"):
            raise ValueError(f"a gripper does not know the action {action!r}; give 'open' or 'close'")
        return self.open(current_joint_positions) if action == "open" else self.close(current_joint_positions)

    @abstractmethod
    def open(self, current_joint_positions: np.ndarray) -> ArticulationAction:
        """Return what opens the gripper; for scripts to define."""
        raise NotImplementedError

    @abstractmethod
    def close(self, current_joint_positions: np.ndarray) -> ArticulationAction:
        """Return what closes the gripper; for scripts to define."""
        raise NotImplementedError
