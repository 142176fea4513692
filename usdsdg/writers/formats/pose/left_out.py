"""Frames that a writer leaves out, since no object that it could train with is visible in them."""

from collections.abc import Sequence

from usdsdg.errors import counted, warn_once


class LeftOut:
    """Counts frames, and those that were left out."""

    def __init__(self) -> None:
        self.last_is_valid = True
        self._frames = self._left_out = 0

    @property
    def counts(self) -> list[int]:
        """How many frames there were, how many of them were left out, and 1 if the last one was not."""
        return [self._frames, self._left_out, int(self.last_is_valid)]

    @counts.setter
    def counts(self, values: Sequence[int]) -> None:
        self._frames, self._left_out = values[:2]
        self.last_is_valid = bool(values[2])

    def note(self, is_valid: bool) -> bool:
        """Count a frame, valid if an object is visible in it; return whether to write it."""
        self.last_is_valid = is_valid
        self._frames += 1
        self._left_out += not is_valid
        return is_valid

    def warn(self, writer: str) -> None:
        """Warn if all frames were left out, so that nothing was written."""
        if self._frames and self._left_out == self._frames:
            frames = counted(self._frames, "frame")
            warn_once(f"{writer} wrote none of {frames}, since no labeled object is visible in any")


class LeavesFramesOut:
    """What writers that leave frames out have in common. `_counts` is among what they keep for a run that goes on."""

    _left_out: LeftOut

    def is_last_frame_valid(self) -> bool:
        """Return whether an object was visible in the last frame, so that it was written."""
        return self._left_out.last_is_valid

    @property
    def _counts(self) -> list[int]:
        return self._left_out.counts

    @_counts.setter
    def _counts(self, values: list[int]) -> None:
        self._left_out.counts = values
