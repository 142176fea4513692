"""Frames in hand: which files belong to each, and whether all of them have been written."""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Collection
from dataclasses import dataclass, field

from usdsdg.writers.journal import lines

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
    due: Counter[str] = field(default_factory=Counter)  # writers by folder that have not been given it in full
    why: dict[str, str] = field(default_factory=dict)  # by folder: the error of a writer there
    holds: int = 1  # open jobs, and the capture itself
    lacking: set[str] = field(default_factory=set)  # folders without a file that could not be written
    is_taken_back: bool = False  # it ended before any writer had it
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def hold(self) -> None:
        """Keep it from being whole until `release`."""
        with self._lock:
            self.holds += 1

    def release(self, *, failed: bool = False, folder: str | None = None) -> None:
        """End what `hold` has begun.

        failed: a file is missing, so it will never be whole. folder: in which the file is missing; others: in all.
        """
        with self._lock:
            if failed:  # first: whoever finds that nothing waits looks at it
                self.lacking |= {folder} if folder is not None and folder in self.folders else self.folders.keys()
            self.holds -= 1

    def take_back(self) -> None:
        """End it as if it had not begun: no writer has had it."""
        self.is_taken_back = True
        self.release()

    def touch(self, folder: str) -> dict[str, FileFacts]:
        """Return its files in a folder, to which it belongs from now on."""
        with self._lock:
            return self.folders.setdefault(folder, {})

    def expect(self, folder: str) -> None:
        """Tell that a writer is to write it to a folder; `arrive` follows when the writer has."""
        self.touch(folder)
        self.due[folder] += 1

    def arrive(self, folder: str) -> None:
        """Tell that a writer has written it, or scheduled that."""
        self.due[folder] -= 1

    def note(self, folder: str, path: str, facts: FileFacts) -> None:
        """Tell that a file of it has been written."""
        files = self.touch(folder)
        with self._lock:
            files[path] = facts

    def keep(self, folder: str, writer: str, values: dict[str, object]) -> None:
        """Tell what a writer keeps after this frame; writer: its key."""
        self.states.setdefault(folder, {})[writer] = values

    def line(self, folder: str) -> dict[str, object]:
        """Return what the journal of a folder says of it."""
        told: dict[str, object] = {lines.FRAME: self.number, lines.FILES: dict(sorted(self.folders[folder].items()))}
        told |= {lines.FAILED: why} if (why := self.failure(folder)) else {}
        return told | ({lines.STATE: states} if (states := self.states.get(folder)) else {})

    def failure(self, folder: str) -> str:
        """Return why a writer has not written all of it to a folder; "" if all have."""
        return self.why.get(folder, "it was interrupted") if self.due[folder] > 0 else ""

    @property
    def has_ended(self) -> bool:
        """Whether nothing of it waits to be written: it is whole, or never will be."""
        return self.holds == 0


Told = tuple[FrameFiles, str]  # a frame, and a folder in which it is whole


class FramesInHand:
    """The captured frames that are not in the journal yet, oldest first.

    Where a file of a frame could not be written, the journal of its folder ends before it, so that going on makes it
    again. Where a writer failed and the script went on, the frame counts with the files that it has, once a later one
    is whole, or the run is. Other folders are as if it had not been.
    """

    def __init__(self) -> None:
        self._frames: deque[FrameFiles] = deque()
        self._whole: list[Told] = []
        self._failed: list[Told] = []  # by a writer; the script has not gone on yet
        self._lacking: set[str] = set()  # folders of frames that will never be whole
        self._lock = threading.Lock()

    def begin(self, number: int) -> FrameFiles:
        """Begin a frame; the capture ends it with `release`."""
        frame = FrameFiles(number)
        with self._lock:
            self._frames.append(frame)
        return frame

    def whole(self) -> list[Told]:
        """Return the frames that are whole, up to the first one that may still become so; they stay until `forget`."""
        with self._lock:
            self._sort_out()
            return list(self._whole)

    def forget(self, frames: Collection[Told]) -> None:
        """Remove frames that `whole` has returned, which are in the journals."""
        with self._lock:
            self._whole = [each for each in self._whole if each not in frames]

    def count_whole(self) -> int:
        """Return how many frames `whole` would return."""
        with self._lock:
            self._sort_out()
            return len(self._whole)

    def accept_failed(self) -> None:
        """Let frames at which a writer failed count, since the run is whole: the script went on after the last one."""
        with self._lock:
            self._sort_out()
            self._whole += self._failed
            self._failed = []

    def has_open(self, folder: str) -> bool:
        """Return whether files of a folder may still be written, of frames that have begun."""
        with self._lock:
            return any(folder in each.folders and not each.has_ended for each in self._frames)

    def lacks(self, folder: str) -> bool:
        """Return whether a folder lacks a frame that was begun: it has failed, or has not ended."""
        with self._lock:
            self._sort_out()
            failed = any(each == folder for _, each in self._failed)
            return failed or folder in self._lacking or bool(self._frames)

    def _sort_out(self) -> None:
        while self._frames and self._frames[0].has_ended:
            frame = self._frames.popleft()
            if frame.is_taken_back:
                continue
            self._lacking |= frame.lacking
            for folder in (each for each in frame.folders if each not in self._lacking):
                if frame.failure(folder):
                    self._failed.append((frame, folder))
                    continue
                self._whole += [each for each in self._failed if each[1] == folder]
                self._failed = [each for each in self._failed if each[1] != folder]
                self._whole.append((frame, folder))
