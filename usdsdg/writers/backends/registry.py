"""Backends by name: what `rep.backends` offers."""

from collections.abc import Mapping
from typing import Any

from usdsdg.arguments.registry import Registry
from usdsdg.errors import WriterRegistryError
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.group import BackendGroup
from usdsdg.writers.backends.store import S3Backend, StoreBackend
from usdsdg.writers.options import check_names

registered: Registry[type[BaseBackend]] = Registry("backend", WriterRegistryError)


def register(backend: type[BaseBackend]) -> None:
    """Register a subclass of BaseBackend under its class name.

    Raises:
        WriterRegistryError: `backend` is no such class.
    """
    if not isinstance(backend, type) or not issubclass(backend, BaseBackend):
        raise WriterRegistryError(f"{backend!r} is not a subclass of BaseBackend.")
    registered.add(backend.__name__, backend)


def unregister(name: str) -> None:
    """Remove a backend from the registry; existing instances keep working.

    Raises:
        WriterRegistryError: there is no such backend; the message lists near misses.
    """
    registered.remove(name)


def get(name: str, init_params: Mapping[str, Any] | None = None) -> BaseBackend:
    """Return a backend by name; without `init_params` it must still be initialized.

    Raises:
        WriterRegistryError: there is no such backend; the message lists near misses.
        WriterError: an argument is unknown, or a required one is missing.
    """
    backend_class = registered.get(name)
    backend = backend_class.__new__(backend_class)
    if init_params is not None:
        check_names(name, backend_class.__init__, init_params)
        backend.initialize(**init_params)
    return backend


class BackendRegistry:
    """The functions of `rep.backends` under Replicator's names."""

    register_backend = staticmethod(register)
    unregister_backend = staticmethod(unregister)
    get_backend = staticmethod(get)
    get_registered_backends = staticmethod(registered.names)


for _backend_class in (DiskBackend, S3Backend, StoreBackend, BackendGroup):
    register(_backend_class)
