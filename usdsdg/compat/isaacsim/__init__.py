"""`isaacsim`: the standalone application object."""

from usdsdg.compat.isaacsim.simulation_app import SimulationApp

__all__ = ["SimulationApp"]
