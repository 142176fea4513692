"""`isaacsim.core.api`: a world with its physics, clock and objects."""

from usdsdg.compat.isaacsim.core.api.physics_context import PhysicsContext
from usdsdg.compat.isaacsim.core.api.simulation_context import SimulationContext
from usdsdg.compat.isaacsim.core.api.world import World

__all__ = ["PhysicsContext", "SimulationContext", "World"]
