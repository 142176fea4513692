"""Printing of results, whatever is in them and wherever they go."""

import errno
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from click.exceptions import Exit


@contextmanager
def printing() -> Iterator[None]:
    """Run a command; what it prints and cannot be written, as where a disk is full, is an error of one line.

    Raises:
        SystemExit: it cannot.
    """
    try:
        try:
            yield
        finally:
            _flush()
    except OSError as error:
        if not _is_of_stdout(error):
            raise
        if error.errno != errno.EPIPE:
            _tell(error)
        _leave_out_the_rest()
        sys.exit(1)


def _is_of_stdout(error: OSError) -> bool:
    """Return whether an error came of printing: no more can be printed then, while those of files may name these."""
    if error.filename is not None:
        return False
    try:
        _flush("\n")
    except OSError as again:
        return again.errno == error.errno
    return False


def _flush(text: str = "") -> None:
    """Print all that is still to be printed, and a text; `sys.stdout` itself may be one of a script's own."""
    stream = sys.__stdout__
    if stream is not None and not stream.closed:
        if text:  # even nothing cannot be written to some, as to one that a script has closed
            stream.write(text)
        stream.flush()


def print_lines(lines: Iterable[str]) -> None:
    """Print lines to stdout; characters that its encoding does not have are written as escapes.

    Raises:
        Exit: it cannot be written to, as where a disk is full; a line on stderr has told so.
    """
    encoding = sys.stdout.encoding or "utf-8"
    try:
        for line in lines:
            print(line.encode(encoding, "backslashreplace").decode(encoding))
        sys.stdout.flush()
    except OSError as error:
        if error.errno == errno.EPIPE:  # the reader has had enough, as `head` does; click ends quietly
            raise
        _tell(error)
        _leave_out_the_rest()
        raise Exit(1) from None


def _tell(error: OSError) -> None:
    print(f"error: the results cannot be printed: {error.strerror}", file=sys.stderr)


def _leave_out_the_rest() -> None:
    """Let what is still to be printed go nowhere: Python writes it when it ends, and would complain once more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
