"""`isaacsim.replicator.writers`: the writers that Isaac Sim adds to Replicator's."""

from usdsdg.writers import DOPEWriter, PoseWriter, PytorchWriter, YCBVideoWriter
from usdsdg.writers.formats.pytorch.pytorch_listener import PytorchListener
from usdsdg.writers.formats.writer_data_visualization import DataVisualizationWriter

__all__ = [
    "DOPEWriter", "DataVisualizationWriter", "PoseWriter", "PytorchListener", "PytorchWriter", "YCBVideoWriter",
]  # fmt: skip
