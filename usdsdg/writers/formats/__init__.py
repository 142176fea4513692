"""The writers, one module for each, and what they share. Importing this package loads them all."""

from usdsdg.writers.formats.bop.writer_bop import BopWriter
from usdsdg.writers.formats.coco.writer_coco import CocoWriter
from usdsdg.writers.formats.cosmos.writer_cosmos import CosmosWriter
from usdsdg.writers.formats.cvat.writer_cvat import CvatWriter
from usdsdg.writers.formats.dope.writer_dope import DOPEWriter
from usdsdg.writers.formats.kitti.writer_kitti import KittiWriter
from usdsdg.writers.formats.pose.writer_pose import PoseWriter
from usdsdg.writers.formats.pytorch.writer_pytorch import PytorchWriter
from usdsdg.writers.formats.rerun.writer_rerun import RerunWriter
from usdsdg.writers.formats.shards.writer_parquet import ParquetWriter
from usdsdg.writers.formats.shards.writer_webdataset import WebDatasetWriter
from usdsdg.writers.formats.voc.writer_voc import VocWriter
from usdsdg.writers.formats.writer_basic import BasicWriter
from usdsdg.writers.formats.writer_data_visualization import DataVisualizationWriter
from usdsdg.writers.formats.writer_fps import FPSWriter
from usdsdg.writers.formats.ycb_video.writer_ycb_video import YCBVideoWriter
from usdsdg.writers.formats.yolo.writer_yolo import YoloWriter

# Registered from the start, in the order of `writers.get_writers()`.
DEFAULT_WRITERS = (
    BasicWriter, PoseWriter, CocoWriter, KittiWriter, CosmosWriter, FPSWriter, DataVisualizationWriter, YoloWriter,
    BopWriter, DOPEWriter, YCBVideoWriter, PytorchWriter, WebDatasetWriter, ParquetWriter, VocWriter, CvatWriter,
    RerunWriter,
)  # fmt: skip
