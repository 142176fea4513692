"""Standard streams that the caller has closed, as `2>&-` does: what is printed to them goes nowhere."""

import os
import sys


def replace_closed_streams() -> None:
    """Give stdout and stderr, which are None where they are closed, a place.

    Their numbers would otherwise be those of the next files that are opened, into which libraries then print.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - it stays open
