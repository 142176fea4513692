"""`domain_randomization.trigger`: the trigger of reinforcement learning frames."""

from __future__ import annotations

from usdsdg.compat.isaacsim.replicator.randomization.registry import get_registry
from usdsdg.compat.isaacsim.replicator.randomization.rl_frames import RlFrames
from usdsdg.graph.node import ReplicatorItem


def on_rl_frame(num_envs: int) -> ReplicatorItem:
    """Run what is inside at every `physics_view.step_randomization`; views have one prim per environment.

    There is one such trigger; another one replaces it.
    """
    get_registry().frames = frames = RlFrames(int(num_envs))
    return frames.item
