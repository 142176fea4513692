"""`from omni.replicator.core.scripts.writers_default.kittiwriter import KittiWriter`."""

from usdsdg.writers.formats.kitti.writer_kitti import KittiWriter

__all__ = ["KittiWriter"]
