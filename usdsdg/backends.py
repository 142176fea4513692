"""Where bytes go (`rep.backends`): the names of `usdsdg.writers.backends.catalogue` that scripts use."""

from usdsdg.session.session import current
from usdsdg.writers.backends.catalogue import (
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

io_queue = current().io_queue

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
