"""The status of the orchestrator, and who is called when it changes."""

from __future__ import annotations

import enum
import itertools
from collections.abc import Callable

from usdsdg.errors import UsdsdgError
from usdsdg.session.session import current


class OrchestratorError(UsdsdgError, RuntimeError):
    """The orchestrator cannot do that now."""


class Status(enum.Enum):
    """What the orchestrator does now. Mirrors `rep.orchestrator.Status`."""

    STOPPED = 0
    STARTED = 1
    STARTING = 2
    LOADING = 3
    STOPPING = 4
    PAUSED = 5
    INITIALIZING = 6
    STEPPING = 7
    STEPPED = 8


class StatusCallback:
    """Calls `function(status)` at every change of status, from `register` to `unregister`, or until nobody holds it."""

    _made = itertools.count()

    def __init__(self, function: Callable[[Status], None]) -> None:
        self.function = function
        self.number = next(self._made)

    def register(self) -> None:
        """Call the function at changes from now on."""
        current().orchestrator.status_callbacks.add(self)

    def unregister(self) -> None:
        """Call the function no more."""
        current().orchestrator.status_callbacks.discard(self)
