"""`domain_randomization.context`: step the randomization, and what was reset."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.isaacsim.replicator.randomization.registry import get_registry


def trigger_randomization(reset_inds: Sequence[int] | np.ndarray) -> None:
    """Randomize one frame, and reset the environments with these numbers."""
    get_registry().running().step(reset_inds)


def get_reset_inds() -> np.ndarray:
    """Return the numbers of the environments that the latest frame reset."""
    return get_registry().running().reset_rows
