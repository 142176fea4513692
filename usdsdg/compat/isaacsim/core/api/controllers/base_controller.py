"""`BaseController`: what a script derives its controllers from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from usdsdg.compat.isaacsim.core.utils.types import ArticulationAction


class BaseController(ABC):
    """A controller with a name."""

    def __init__(self, name: str) -> None:
        self._name = name

    @abstractmethod
    def forward(self, *args: Any, **kwargs: Any) -> ArticulationAction:
        """Return what joints shall do; for the controllers of scripts to define."""
        raise NotImplementedError

    def reset(self) -> None:  # noqa: B027 - controllers may define it
        """Do nothing, unless a controller of a script has something to forget."""
