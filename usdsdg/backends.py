"""Backends, which store the files of writers. Mirrors `rep.backends`."""

from usdsdg.arguments.parameters import name_parameters
from usdsdg.session.session import current
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.group import BackendDispatch, BackendGroup
from usdsdg.writers.backends.registry import BackendRegistry, get, register, unregister
from usdsdg.writers.backends.sequential import Sequential
from usdsdg.writers.backends.store import S3Backend, StoreBackend

io_queue = current().io_queue

__all__ = [
    "BackendDispatch", "BackendGroup", "BackendRegistry", "BaseBackend", "DiskBackend", "S3Backend", "Sequential",
    "StoreBackend", "get", "io_queue", "register", "unregister",
]  # fmt: skip

name_parameters(globals(), without_turns=None)
