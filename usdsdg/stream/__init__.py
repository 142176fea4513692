"""Frames of a job or a script in memory, as they are rendered: `frames`."""

from usdsdg.stream.sample import Sample
from usdsdg.stream.source import Source
from usdsdg.stream.stream import frames

__all__ = ["Sample", "Source", "frames"]
