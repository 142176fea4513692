"""Which frames of a run one process makes: all, some in a row, or every n-th."""

from __future__ import annotations

import re
from dataclasses import dataclass

from usdsdg.errors import BadValue


@dataclass(frozen=True)
class Portion:
    """The frames `first` to `last` (exclusive; None: to the end), of which every `of`-th from `part` on.

    Frames are counted from 0 over all captures of a run at which a writer is due.
    """

    first: int = 0
    last: int | None = None
    part: int = 0
    of: int = 1
    numbers: frozenset[int] | None = None  # of these the ones that are made; None: all

    @classmethod
    def of_numbers(cls, text: str) -> Portion:
        """Parse "A:B", as `of_frames`, or numbers of frames with commas.

        Raises:
            BadValue: it is nothing of this form, or has no frames.
        """
        if ":" in text:
            return cls.of_frames(text)
        if re.fullmatch(r"\s*\d+\s*(,\s*\d+\s*)*", text) is None:
            raise BadValue(f"--frames {text!r}: expected A:B, or numbers of frames with commas, such as 0,12")
        numbers = frozenset(map(int, text.split(",")))
        return cls(min(numbers), max(numbers) + 1, numbers=numbers)

    @classmethod
    def of_frames(cls, text: str) -> Portion:
        """Parse "A:B": the frames from A up to B, without B; either may be left out.

        Raises:
            BadValue: it is nothing of this form, or has no frames.
        """
        match = re.fullmatch(r"(\d*):(\d*)", text.strip())
        if match is None:
            raise BadValue(f"--frames {text!r}: expected A:B, such as 0:500 for the first 500 frames")
        first, last = int(match[1] or 0), int(match[2]) if match[2] else None
        if last is not None and last <= first:
            raise BadValue(f"--frames {text!r}: there are no frames from {first} up to {last}")
        return cls(first, last)

    @classmethod
    def of_name(cls, name: str) -> Portion | None:
        """Return the portion of a `name`; None if it is none."""
        if match := re.fullmatch(r"(\d+)-of-(\d+)", name):
            return cls(part=int(match[1]), of=int(match[2]))
        if match := re.fullmatch(r"(\d+)-(\d+|end)", name):
            return cls(int(match[1]), None if match[2] == "end" else int(match[2]))
        return None

    @classmethod
    def of_shard(cls, text: str) -> Portion:
        """Parse "i/n": the i-th of n parts, from 0.

        Raises:
            BadValue: it is nothing of this form, or there is no such part.
        """
        match = re.fullmatch(r"(\d+)/(\d+)", text.strip())
        if match is None or not int(match[1]) < int(match[2]):
            raise BadValue(f"--shard {text!r}: expected i/n with i from 0 to n - 1, such as 0/4 for the first of four")
        return cls(part=int(match[1]), of=int(match[2]))

    def has(self, frame: int) -> bool:
        """Return whether this process makes a frame."""
        if frame < self.first or (self.last is not None and frame >= self.last):
            return False
        return frame % self.of == self.part and (self.numbers is None or frame in self.numbers)

    def count(self, frames: int) -> int:
        """Return how many of the first `frames` frames of the run this process makes."""
        if self.numbers is not None:
            return sum(number < frames for number in self.numbers)
        end = frames if self.last is None else min(frames, self.last)
        return len(range(self.first + (self.part - self.first) % self.of, end, self.of))

    def is_over(self, frame: int) -> bool:
        """Return whether neither this frame nor a later one is this process's."""
        return self.last is not None and frame >= self.last

    @property
    def name(self) -> str:
        """A name for files: "0-500" for frames, "1-of-4" for a shard."""
        if self.of > 1:
            return f"{self.part}-of-{self.of}"
        return f"{self.first}-{'end' if self.last is None else self.last}"
