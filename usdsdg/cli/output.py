"""Printing of results, whatever is in them and wherever they go."""

import errno
import os
import sys
from collections.abc import Iterable

from click.exceptions import Exit


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
        print(f"error: the results cannot be printed: {error.strerror}", file=sys.stderr)
        # Python writes what is left when it ends, and would complain once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        raise Exit(1) from None
