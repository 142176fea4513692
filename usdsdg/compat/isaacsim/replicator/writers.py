"""`isaacsim.replicator.writers`: the writers that Isaac Sim adds to Replicator's."""

from usdsdg.writers import PoseWriter
from usdsdg.writers.formats.writer_data_visualization import DataVisualizationWriter

__all__ = ["DataVisualizationWriter", "PoseWriter"]
