"""The writers that are registered from the start, at the place where scripts import them from."""

from usdsdg.writers import BasicWriter, PoseWriter

__all__ = ["BasicWriter", "PoseWriter"]
