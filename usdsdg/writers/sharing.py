"""Several writers in one output folder, of which each counts its files from 0."""

from usdsdg.errors import warn_once
from usdsdg.session.session import current


def note_writer(place: str, turn: object, kind: type) -> None:
    """Tell that a writer is due whose files go to a folder or URL, and warn if another one was due there before.

    turn: stands for the writer since it was initialized. kind: its class. Also where the other one has ended with an
    earlier stage, or where a process of another part writes its files.
    """
    current().writers_kinds.setdefault(place, set()).add(kind)
    if current().writers_turns.setdefault(place, turn) is not turn:
        warn_of_sharing(place)


def warn_of_sharing(place: str) -> None:
    """Warn that writers with the same folder replace each other's files."""
    warn_once(
        f"{place} is written to by several writers: files of the same names, such as metadata.txt, replace each other. "
        "Give each writer an output_dir of its own."
    )
