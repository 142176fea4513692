"""`domain_randomization.gate`: which environments are randomized at a frame."""

from __future__ import annotations

from usdsdg.arguments.values import whole_number
from usdsdg.compat.isaacsim.replicator.randomization.registry import get_registry
from usdsdg.graph.node import ReplicatorItem


def on_interval(interval: int) -> ReplicatorItem:
    """Randomize an environment at every `interval`-th step after its last reset.

    Raises:
        GraphError: `interval` is not an integer or below 1, or it is not inside of `with trigger.on_rl_frame(...):`.
    """
    whole_number("interval", interval, least=1)
    return get_registry().running().add_interval(int(interval))


def on_env_reset() -> ReplicatorItem:
    """Randomize the environments that `step_randomization` resets; these values are what gates by interval start from.

    Raises:
        GraphError: it is not inside of `with trigger.on_rl_frame(...):`.
    """
    return get_registry().running().add_reset()
