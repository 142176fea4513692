"""`omni.replicator.core.bindings._omni_replicator_core`: the telemetry that copies of Replicator's writers create."""

from collections.abc import Callable
from typing import Any


class Schema_omni_replicator_extinfo_1_0:  # Replicator's name
    """Takes every event and sends none."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        if name.startswith("__"):
            raise AttributeError(name)
        return _ignore


def _ignore(*values: Any, **arguments: Any) -> None:
    """Send nothing."""
