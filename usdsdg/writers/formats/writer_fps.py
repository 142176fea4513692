"""FPSWriter: time per frame."""

import time
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.writers.base import Writer
from usdsdg.writers.options import typed


class FPSWriter(Writer):
    """Prints the seconds between one frame and the next, and at the end of a run their mean; writes no files.

    Attached next to another writer it measures that writer's rate; it causes color to be rendered in any case. The
    seconds are stored in `times_per_frame`.
    """

    shares_arrays = True

    @typed
    def __init__(self) -> None:
        self.annotators = [named_annotators.get("LdrColor")]
        self.times_per_frame: list[float] = []
        self._last: float | None = None

    def write(self, data: dict[str, Any]) -> None:
        now = time.perf_counter()
        if self._last is not None:
            self.times_per_frame.append(now - self._last)
            print(self.times_per_frame[-1])
        self._last = now

    def on_final_frame(self) -> None:
        """Print the mean; the pause until the next run is not counted."""
        self._last = None
        if self.times_per_frame:
            print("COMPLETE")
            print(f"AVERAGE TIME PER FRAME: {sum(self.times_per_frame) / len(self.times_per_frame)}")
