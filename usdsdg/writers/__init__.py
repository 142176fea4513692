"""Writers: frames to files (`rep.writers`, `rep.backends`)."""

from usdsdg.errors import OutputNotWritable, WriterError, WriterRegistryError
from usdsdg.writers.backends.catalogue import BackendDispatch, BackendGroup, BaseBackend, DiskBackend, set_disk_root
from usdsdg.writers.base import Writer, attached_writers, detach_all, set_global_seed
from usdsdg.writers.catalogue import (
    WriterRegistry,
    get,
    get_writers,
    register_node_writer,
    register_writer,
    unregister_writer,
)
from usdsdg.writers.formats.writer_basic import BasicWriter
from usdsdg.writers.formats.writer_coco import CocoWriter
from usdsdg.writers.formats.writer_cosmos import CosmosWriter
from usdsdg.writers.formats.writer_fps import FPSWriter
from usdsdg.writers.formats.writer_kitti import KittiWriter
from usdsdg.writers.formats.writer_pose import PoseWriter

for _writer in (BasicWriter, PoseWriter, CocoWriter, KittiWriter, CosmosWriter, FPSWriter):
    register_writer(_writer)

__all__ = [
    "BackendDispatch",
    "BackendGroup",
    "BaseBackend",
    "BasicWriter",
    "CocoWriter",
    "CosmosWriter",
    "DiskBackend",
    "FPSWriter",
    "KittiWriter",
    "OutputNotWritable",
    "PoseWriter",
    "Writer",
    "WriterError",
    "WriterRegistry",
    "WriterRegistryError",
    "attached_writers",
    "detach_all",
    "get",
    "get_writers",
    "register_node_writer",
    "register_writer",
    "set_disk_root",
    "set_global_seed",
    "unregister_writer",
]
