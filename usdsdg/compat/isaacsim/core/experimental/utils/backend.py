"""`isaacsim.core.experimental.utils.backend`: the backends of wrappers, all of which are the USD stage."""

from __future__ import annotations

import contextlib
import enum
from collections.abc import Generator, Sequence

_BACKENDS = ("usd", "usdrt", "fabric", "tensor", "simstate")
_chosen: list[tuple[str, bool, bool]] = []


class SimStateMode(enum.StrEnum):
    """Whether data of articulations are kept in the state of a simulation as well, or there alone."""

    DISABLED = "disabled"
    EXCLUSIVE = "exclusive"
    MIRROR = "mirror"


def get_simstate_mode() -> SimStateMode:
    """Return DISABLED, also in a block of the backend "simstate": the state is that of the USD stage."""
    return SimStateMode.DISABLED


@contextlib.contextmanager
def use_backend(
    backend: str, *, raise_on_unsupported: bool = False, raise_on_fallback: bool = False
) -> Generator[None, None, None]:
    """Name the backend inside the `with` block; each reads and writes the USD stage, where physics keeps its results.

    Raises:
        ValueError: there is no such backend.
    """
    if backend not in _BACKENDS:
        raise ValueError(f"there is no backend {backend!r}; backends are {', '.join(_BACKENDS)}")
    _chosen.append((backend, raise_on_unsupported, raise_on_fallback))
    try:
        yield
    finally:
        _chosen.pop()


def get_current_backend(supported_backends: Sequence[str], *, raise_on_unsupported: bool | None = None) -> str:
    """Return the backend of the `with` block if it is among these, else the first of them.

    Raises:
        RuntimeError: it is not among them, and `raise_on_unsupported`.
    """
    backend = _chosen[-1][0] if _chosen else supported_backends[0]
    if backend in supported_backends:
        return backend
    if should_raise_on_unsupported() if raise_on_unsupported is None else raise_on_unsupported:
        raise RuntimeError(f"backend {backend!r} is not among {', '.join(supported_backends)}")
    return supported_backends[0]


def is_backend_set() -> bool:
    return bool(_chosen)


def should_raise_on_unsupported() -> bool:
    return bool(_chosen) and _chosen[-1][1]


def should_raise_on_fallback() -> bool:
    return bool(_chosen) and _chosen[-1][2]
