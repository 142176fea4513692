"""`from omni.replicator.core.scripts.writers_default.cocowriter import CocoWriter`."""

from usdsdg.writers.formats.coco.writer_coco import CocoWriter

__all__ = ["CocoWriter"]
