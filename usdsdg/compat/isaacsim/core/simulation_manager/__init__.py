"""`isaacsim.core.simulation_manager`: physics steps under a script's own control, and their events."""

from usdsdg.compat.isaacsim.core.simulation_manager.isaac_events import IsaacEvents
from usdsdg.compat.isaacsim.core.simulation_manager.physics_scene import PhysicsScene, PhysxGpuCfg, PhysxScene
from usdsdg.compat.isaacsim.core.simulation_manager.simulation_event import SimulationEvent
from usdsdg.compat.isaacsim.core.simulation_manager.simulation_manager import SimulationManager

__all__ = ["IsaacEvents", "PhysicsScene", "PhysxGpuCfg", "PhysxScene", "SimulationEvent", "SimulationManager"]
