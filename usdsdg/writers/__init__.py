"""Writers: annotations to files in the formats of datasets (`rep.writers`, `rep.backends`)."""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.errors import InvalidWriterError, OutputNotWritable, WriterError, WriterRegistryError
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend, set_disk_root
from usdsdg.writers.backends.group import BackendDispatch, BackendGroup
from usdsdg.writers.base import Writer, attached_writers, detach_all
from usdsdg.writers.formats import (
    DEFAULT_WRITERS,
    BasicWriter,
    BopWriter,
    CocoWriter,
    CosmosWriter,
    CvatWriter,
    DOPEWriter,
    FPSWriter,
    KittiWriter,
    ParquetWriter,
    PoseWriter,
    PytorchWriter,
    VocWriter,
    WebDatasetWriter,
    YCBVideoWriter,
    YoloWriter,
)
from usdsdg.writers.global_seed import set_global_seed
from usdsdg.writers.registry import (
    WriterRegistry,
    get,
    get_writers,
    register_node_writer,
    register_writer,
    unregister_writer,
)

for _writer in DEFAULT_WRITERS:
    register_writer(_writer)

__all__ = [
    # writers by name
    "get", "get_writers", "WriterRegistry",
    # the formats
    "BasicWriter", "PoseWriter", "CocoWriter", "KittiWriter", "CosmosWriter", "FPSWriter",
    "YoloWriter", "BopWriter", "DOPEWriter", "YCBVideoWriter", "PytorchWriter",
    "WebDatasetWriter", "ParquetWriter", "VocWriter", "CvatWriter",
    # writers of one's own
    "Writer", "register_writer", "register_node_writer", "unregister_writer",
    # where files go
    "BaseBackend", "DiskBackend", "BackendGroup", "BackendDispatch", "set_disk_root",
    # what a capture needs
    "attached_writers", "detach_all", "set_global_seed",
    # errors
    "InvalidWriterError", "OutputNotWritable", "WriterError", "WriterRegistryError",
]  # fmt: skip

name_parameters(globals())
