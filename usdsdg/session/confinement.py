"""Confinement of output: what a file that is no program says, such as a YAML graph, goes below one folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from usdsdg.session.session import current


@contextmanager
def confined(folder: Path | None) -> Iterator[None]:
    """Let backends that are made meanwhile write below a folder only; None: anywhere."""
    session = current()
    before, session.confined_to = session.confined_to, folder
    try:
        yield
    finally:
        session.confined_to = before
