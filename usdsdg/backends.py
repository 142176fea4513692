"""Where bytes go (`rep.backends`): the names of `usdsdg.writers.backends` that scripts use."""

from usdsdg.writers.backends import (
    BackendDispatch,
    BackendGroup,
    BackendRegistry,
    BaseBackend,
    DiskBackend,
    S3Backend,
    get,
    register,
    unregister,
)
from usdsdg.writers.io_queue import io_queue

__all__ = [
    "BackendDispatch",
    "BackendGroup",
    "BackendRegistry",
    "BaseBackend",
    "DiskBackend",
    "S3Backend",
    "get",
    "io_queue",
    "register",
    "unregister",
]
