"""Folders of datasets that the script has moved or removed itself, while it runs or after its last file."""

from __future__ import annotations

from collections.abc import Iterable

from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.frames import FramesInHand


def leave(name: str, folders: dict[str, DatasetFolder], frames: FramesInHand) -> bool:
    """Let a folder go that is not there any more, so that another dataset can be made there; return whether it is so.

    Where it was moved, its journal goes on there. frames: that wait to be told to journals.

    Raises:
        OutputNotWritable: where it was moved cannot be written to.
    """
    folder = folders.get(name)
    if folder is None or (folder.journal.path.exists() and not folder.has_moved):
        return False
    del folders[name]
    whole = [each for each in frames.whole() if each[1] == name]
    if folder.has_moved or folder.follow(tells=False):
        folder.append([frame.line(name) for frame, _ in whole if not folder.journal.has(frame.number)])
        folders[folder.place.name] = folder
    else:
        folder.release()
    frames.forget(whole)
    return True


def follow(names: Iterable[str], folders: dict[str, DatasetFolder]) -> None:
    """Find which of the named folders the script has moved; report those that it has removed, and forget them."""
    for name in names:
        if not folders[name].place.exists() and not folders[name].follow():
            folders.pop(name).release()
