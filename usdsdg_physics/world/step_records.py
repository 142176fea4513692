"""Record the kernel launches of a step or a part of it, and replay them without Python."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING

from usdsdg.errors import warn_once
from usdsdg_physics.world.captures_by_thread import keep_captures_by_thread

if TYPE_CHECKING:
    import warp as wp

# A step, or a part of one, is recorded when one of its kind is taken for this many times: the first launches load
# modules and allocate, which a record must not contain, and the step rates of motion blur come and go.
RECORD_AT_USE = 2
# Some rate that a script draws anew for each frame must not fill the memory.
MAX_RECORDS = 512
MAX_KINDS = 4096


class StepRecords:
    """Records of steps, or of their parts, by kind.

    A step has 55 launches in each substep, and launching them from Python takes longer than the kernels of a hundred
    bodies. What a record launches is what Python launched when it was made, with the same arrays and the same numbers:
    a kind has to tell all steps apart whose launches differ, and what changes between steps of a kind is in arrays.
    """

    def __init__(self, device: wp.Device) -> None:
        self._device = device
        self._records: dict[Hashable, wp.Graph] = {}
        self._uses: dict[Hashable, int] = {}
        self._failed: set[Hashable] = set()

    def run(self, kind: Hashable, launch: Callable[[], object]) -> None:
        """Take a step or a part of a kind, which `launch()` launches; replay it where there is a record."""
        import warp as wp

        if len(self._uses) >= MAX_KINDS:
            self._uses = {recorded: RECORD_AT_USE for recorded in self._records}
        uses = self._uses[kind] = self._uses.get(kind, 0) + 1
        if kind not in self._records and (uses < RECORD_AT_USE or not self._record(kind, launch)):
            launch()
            return
        wp.capture_launch(self._records[kind])

    def _record(self, kind: Hashable, launch: Callable[[], object]) -> bool:
        import warp as wp

        if kind in self._failed:
            return False
        try:
            if self._device.is_cpu:
                keep_captures_by_thread()
            with wp.ScopedCapture(self._device) as capture:
                launch()
        except RuntimeError as error:
            self._failed.add(kind)
            warn_once(
                f"a physics step cannot be recorded on {self._device}, so each is launched from Python, which takes "
                f"longer and gives the same motion: {error}"
            )
            return False
        if len(self._records) >= MAX_RECORDS:
            oldest = next(iter(self._records))
            del self._records[oldest], self._uses[oldest]
        assert capture.graph is not None
        self._records[kind] = capture.graph
        return True
