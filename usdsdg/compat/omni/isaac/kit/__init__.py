"""`omni.isaac.kit`: the standalone application, under its older name."""

from usdsdg.compat.isaacsim.simulation_app import SimulationApp

__all__ = ["SimulationApp"]
