"""`isaacsim.core.api.loggers`: what a world measured at each step, kept and written as JSON."""

from usdsdg.compat.isaacsim.core.api.loggers.data_logger import DataLogger

__all__ = ["DataLogger"]
