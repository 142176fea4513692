"""Frames in hand: which files belong to each, and whether all of them have been written."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

# What is known of a file: its size [bytes] and its SHA-256 as hexadecimal digits.
FileFacts = tuple[int, str]


@dataclass(eq=False)
class FrameFiles:
    """The files of one captured frame, in every folder. It is whole when it has ended and all its jobs have succeeded.

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
            self.has_failed |= failed  # first: whoever finds that nothing waits looks at it
            self.holds -= 1

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
    def has_ended(self) -> bool:
        """Whether nothing of it waits to be written: it is whole, or never will be."""
        return self.holds == 0


class FramesInHand:
    """The captured frames that are not in the journal yet, oldest first.

    A frame that will never be whole, as a script caught an error of a writer and went on, keeps all later ones of its
    folders out of their journals, which then end before it; those of other folders are whole as if it had not been.
    """

    def __init__(self) -> None:
        self._frames: deque[FrameFiles] = deque()
        self._whole: list[FrameFiles] = []
        self._lacking: set[str] = set()  # folders of frames that will never be whole
        self._lock = threading.Lock()

    def begin(self, number: int) -> FrameFiles:
        """Begin a frame; the capture ends it with `release`."""
        frame = FrameFiles(number)
        with self._lock:
            self._frames.append(frame)
        return frame

    def whole(self) -> list[FrameFiles]:
        """Return the frames that are whole, up to the first one that may still become so; they stay until `forget`."""
        with self._lock:
            self._sort_out()
            return list(self._whole)

    def forget(self, frames: Collection[FrameFiles]) -> None:
        """Remove frames that `whole` has returned, which are in the journals."""
        with self._lock:
            self._whole = [each for each in self._whole if each not in frames]

    def count_whole(self) -> int:
        """Return how many frames `whole` would return."""
        with self._lock:
            self._sort_out()
            return len(self._whole)

    def lacks(self, folder: str) -> bool:
        """Return whether a folder lacks a frame that was begun: it has failed, or has not ended."""
        with self._lock:
            self._sort_out()
            return folder in self._lacking or bool(self._frames)

    def _sort_out(self) -> None:
        while self._frames and self._frames[0].has_ended:
            frame = self._frames.popleft()
            if frame.has_failed or not self._lacking.isdisjoint(frame.folders):
                self._lacking |= frame.folders.keys()
            else:
                self._whole.append(frame)
