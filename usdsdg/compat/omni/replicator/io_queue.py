"""`omni.replicator.core.backends.io_queue` as a module: the queue that `rep.backends.io_queue` is, too."""

from typing import Any

from usdsdg.session.session import current


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    return getattr(current().io_queue, name)
