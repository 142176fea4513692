"""Several writers in one output folder, of which each counts its files from 0."""

import weakref
from typing import Any

from usdsdg.errors import warn_once
from usdsdg.session.session import current


def note_writer(place: str, writer: Any) -> None:
    """Tell that a writer is due whose files go to a folder or URL, and warn if another one was due there before.

    So is the same one that was initialized again. Also where the other one has ended with an earlier stage, or where a
    process of another part writes its files.
    """
    session, kind = current(), type(writer)
    session.writers_kinds.setdefault(place, set()).add(kind)
    turn, first = session.writers_turns.setdefault(place, (writer.turn, weakref.ref(writer)))
    if turn is not writer.turn:
        warn_of_sharing(place, again=kind.__name__ if first() is writer else "")


def warn_of_sharing(place: str, *, again: str = "") -> None:
    """Warn that writers with the same folder replace each other's files; again: the one that was initialized again."""
    remedy = "Give each writer an output_dir of its own."
    if again:
        remedy = (
            f"{again} was initialized again, and numbers its files from 0, so that its first frames are lost. "
            "Initialize it once, and attach it again to other render products, or give each time another output_dir."
        )
    warn_once(
        f"{place} is written to by several writers: files of the same names, such as metadata.txt, replace each other. "
        f"{remedy}",
        key=f"several writers in {place}",
    )
