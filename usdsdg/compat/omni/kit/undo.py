"""Groups of commands. Mirrors `omni.kit.undo`, but commands cannot be undone: none keeps what was before it."""

from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.errors import Unsupported

_REMEDY = "keep the value or the layer's text (ExportToString) before the command, and set it again"


@contextmanager
def group() -> Iterator[None]:
    """Run the commands of a block, which would be undone together."""
    yield


@contextmanager
def disabled() -> Iterator[None]:
    """Run the commands of a block, which could not be undone."""
    yield


def begin_group() -> None:
    """Begin commands that would be undone together."""


def end_group() -> None:
    """End what `begin_group` began."""


def begin_disabled() -> None:
    """Begin commands that could not be undone."""


def end_disabled() -> None:
    """End what `begin_disabled` began."""


def clear_stack() -> None:
    """Forget commands, of which none is kept."""


def can_undo() -> bool:
    """Return False: no command is kept."""
    return False


def can_redo() -> bool:
    """Return False: no command is kept."""
    return False


def undo() -> bool:
    """Undo the last command.

    Raises:
        Unsupported: always; the message says what to do instead.
    """
    raise Unsupported(f"omni.kit.undo.undo: commands keep nothing of what was before them; {_REMEDY}")


def redo() -> bool:
    """Repeat what was undone.

    Raises:
        Unsupported: always; the message says what to do instead.
    """
    raise Unsupported(f"omni.kit.undo.redo: nothing can have been undone; {_REMEDY}")
