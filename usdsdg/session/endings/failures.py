"""Errors that a command prints: each cause once, although many files may fail by it."""

from __future__ import annotations

from usdsdg.errors import UsdsdgError, described
from usdsdg.session.progress import print_safely
from usdsdg.session.session import current


def begin() -> None:
    """Forget what was told, as at the beginning of a command: the one before may have failed by the same."""
    current().told_causes.clear()


def tell(error: UsdsdgError, when: str = "") -> None:
    """Print an error to stderr, unless one of the same cause was printed.

    when: what the program did then, such as "at the end of the run: ".
    """
    told, said = current().told_causes, described(error)
    if error.cause in told or said in told:
        return
    told.add(error.cause or said)
    print_safely(f"error: {when}{said}")
