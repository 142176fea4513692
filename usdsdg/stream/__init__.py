"""Frames of a job or a script in memory, as they are rendered: `frames`, and `worlds`, many at a time on the device."""

from usdsdg.capture.worlds import WorldBatch
from usdsdg.stream.sample import Sample
from usdsdg.stream.source import Source
from usdsdg.stream.stream import frames, worlds

__all__ = ["Sample", "Source", "WorldBatch", "frames", "worlds"]
