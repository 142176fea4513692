"""`isaacsim.replicator.domain_randomization`: randomize physics per environment."""

from usdsdg.compat.isaacsim.replicator.domain_randomization import physics_view
from usdsdg.compat.isaacsim.replicator.randomization import context, gate, trigger, utils
from usdsdg.compat.isaacsim.replicator.randomization.attributes import (
    ARTICULATION_ATTRIBUTES,
    RIGID_PRIM_ATTRIBUTES,
    SIMULATION_CONTEXT_ATTRIBUTES,
    TENDON_ATTRIBUTES,
)

__all__ = [
    "ARTICULATION_ATTRIBUTES", "RIGID_PRIM_ATTRIBUTES", "SIMULATION_CONTEXT_ATTRIBUTES", "TENDON_ATTRIBUTES",
    "context", "gate", "physics_view", "trigger", "utils",
]  # fmt: skip
