"""Standard streams that are closed, as by `2>&-`, or that nothing can be written to: commands go on without them."""

import io
import os
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


def replace_closed_streams() -> None:
    """Give stdout and stderr, which are None where they are closed, a place.

    Their numbers would otherwise be those of the next files that are opened, into which libraries then print.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - it stays open


def let_stderr_fail() -> None:
    """Leave out what cannot be written to stderr, as where the reader of a pipe has gone or the disk of a log is full.

    Progress, warnings and errors go there, and a run goes on without them. Results go to stdout; a command that cannot
    write those fails.
    """
    before = sys.stderr
    buffer = getattr(before, "buffer", None)
    if not isinstance(before, io.TextIOWrapper) or not isinstance(getattr(buffer, "raw", buffer), io.FileIO):
        return  # a console of Windows, or a stream of who calls this
    raw = _Lossy(before.fileno(), "wb", closefd=False)
    raw.name = before.name
    kept = io.BufferedWriter(raw) if hasattr(buffer, "raw") else raw  # PYTHONUNBUFFERED has none between
    sys.stderr = sys.__stderr__ = io.TextIOWrapper(
        kept,
        before.encoding,
        before.errors,
        line_buffering=before.line_buffering,
        write_through=before.write_through,
    )


class _Lossy(io.FileIO):
    """A file that takes whatever it is given, and loses what cannot be written."""

    def write(self, b: "ReadableBuffer", /) -> int:
        size = memoryview(b).nbytes
        try:
            written = super().write(b)
        except OSError:
            return size
        return size if written is None else written  # None: it would have had to wait, as a terminal may say
