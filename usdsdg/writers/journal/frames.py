"""Frames in hand: which files belong to each, and whether all of them have been written."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field

# What is known of a file: its size [bytes] and its SHA-256 as hexadecimal digits.
FileFacts = tuple[int, str]


@dataclass(eq=False)
class FrameFiles:
    """The files of one captured frame, in every folder. It is whole when it is closed and all its jobs have succeeded.

    Jobs of the queue of files hold it while they are open; several threads do so at once.
    """

    number: int  # over all captures of the run, from 0
    folders: dict[str, dict[str, FileFacts]] = field(default_factory=dict)  # by folder and path below it
    states: dict[str, dict[str, object]] = field(default_factory=dict)  # by folder: of writers, by their names there
    holds: int = 1  # open jobs, and the capture itself
    has_failed: bool = False
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def hold(self) -> None:
        """Keep it from being whole until `release`."""
        with self._lock:
            self.holds += 1

    def release(self, *, failed: bool = False) -> None:
        """End what `hold` has begun. failed: a file is missing, so it will never be whole."""
        with self._lock:
            self.holds -= 1
            self.has_failed |= failed

    def touch(self, folder: str) -> dict[str, FileFacts]:
        """Return its files in a folder, to which it belongs from now on."""
        with self._lock:
            return self.folders.setdefault(folder, {})

    def note(self, folder: str, path: str, facts: FileFacts) -> None:
        """Tell that a file of it has been written."""
        files = self.touch(folder)
        with self._lock:
            files[path] = facts

    def keep(self, folder: str, writer: str, values: dict[str, object]) -> None:
        """Tell what a writer keeps after this frame; writer: its key."""
        self.states.setdefault(folder, {})[writer] = values

    @property
    def is_whole(self) -> bool:
        """Whether all of its files have been written."""
        return self.holds == 0 and not self.has_failed


class FramesInHand:
    """The captured frames that are not in the journal yet, oldest first."""

    def __init__(self) -> None:
        self._frames: deque[FrameFiles] = deque()
        self._lock = threading.Lock()

    def begin(self, number: int) -> FrameFiles:
        """Begin a frame; the capture ends it with `release`."""
        frame = FrameFiles(number)
        with self._lock:
            self._frames.append(frame)
        return frame

    def take_whole(self) -> list[FrameFiles]:
        """Remove and return the frames that are whole, up to the first one that is not."""
        taken = []
        with self._lock:
            while self._frames and self._frames[0].is_whole:
                taken.append(self._frames.popleft())
        return taken

    def count_whole(self) -> int:
        """Return how many frames `take_whole` would return."""
        with self._lock:
            return next((place for place, each in enumerate(self._frames) if not each.is_whole), len(self._frames))

    def count(self) -> int:
        """Return how many frames are in hand."""
        with self._lock:
            return len(self._frames)
