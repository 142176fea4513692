"""`from omni.replicator.core.scripts.writers_default.fpswriter import FPSWriter`."""

from usdsdg.writers.formats.writer_fps import FPSWriter

__all__ = ["FPSWriter"]
