"""`isaacsim`: the standalone application."""

from usdsdg.compat.isaacsim.simulation_app import SimulationApp

__all__ = ["SimulationApp"]
