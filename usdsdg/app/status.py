"""The status of the orchestrator, and callbacks for its changes."""

import enum
import itertools
from collections.abc import Callable

from usdsdg.errors import UsdsdgError
from usdsdg.session.session import current


class OrchestratorError(UsdsdgError, RuntimeError):
    """The orchestrator cannot run with these arguments or in this state."""


class Status(enum.Enum):
    """The state of the orchestrator. Mirrors `rep.orchestrator.Status`."""

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
    """Calls `function(status)` at status changes while it is registered and referenced by the script."""

    _made = itertools.count()

    def __init__(self, function: Callable[[Status], None]) -> None:
        self.function = function
        self.number = next(self._made)

    def register(self) -> None:
        """Start calling the function."""
        current().orchestrator.status_callbacks.add(self)

    def unregister(self) -> None:
        """Stop calling the function."""
        current().orchestrator.status_callbacks.discard(self)
