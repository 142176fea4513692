"""`from omni.replicator.core.scripts.writers_default.basicwriter import BasicWriter`."""

from usdsdg.writers.formats.writer_basic import BasicWriter

__all__ = ["BasicWriter"]
