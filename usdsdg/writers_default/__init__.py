"""The writers that are registered from the start, at the place where scripts import them from."""

from usdsdg.writers import BasicWriter, CocoWriter, CosmosWriter, FPSWriter, KittiWriter, PoseWriter

__all__ = ["BasicWriter", "CocoWriter", "CosmosWriter", "FPSWriter", "KittiWriter", "PoseWriter"]
