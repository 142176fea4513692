"""`isaacsim`: the standalone application."""

from usdsdg.compat.isaacsim.app_framework import AppFramework
from usdsdg.compat.isaacsim.simulation_app import SimulationApp

__all__ = ["AppFramework", "SimulationApp"]
