"""The built-in writers (`rep.writers_default`), also one module for each, as in Replicator."""

from usdsdg.writers import BasicWriter, CocoWriter, CosmosWriter, FPSWriter, KittiWriter, PoseWriter

__all__ = ["BasicWriter", "CocoWriter", "CosmosWriter", "FPSWriter", "KittiWriter", "PoseWriter"]
