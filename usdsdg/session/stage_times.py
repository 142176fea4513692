"""The time metadata of a stage: its time codes per second, and the range of its animation."""

import math
from typing import NamedTuple

from pxr import Usd

from usdsdg.errors import BadValue

# Of a time, in seconds. Time stamps of frames are whole numbers, which larger times would not have.
MOST_SECONDS = 1e12
# Of a rate, in 1/s: its inverse is what one update of the app simulates.
LEAST_RATE = 1e-3


class StageTimes(NamedTuple):
    """What the layers of a stage say of time; `start` and `end` are time codes, both None where no end is authored."""

    rate: float
    start: float | None
    end: float | None

    @property
    def seconds(self) -> tuple[float, float] | None:
        """The range in seconds; None: none is authored."""
        if self.start is None or self.end is None:
            return None
        return self.start / self.rate, self.end / self.rate


def of_stage(stage: Usd.Stage) -> StageTimes:
    """Read the time metadata of a stage.

    Raises:
        BadValue: its time codes are not finite or too far from 0, or their rate is below LEAST_RATE.
    """
    rate, codes = stage.GetTimeCodesPerSecond(), (stage.GetStartTimeCode(), stage.GetEndTimeCode())
    if not (math.isfinite(rate) and rate >= LEAST_RATE):
        raise BadValue(
            f"{_file(stage)}: timeCodesPerSecond {rate} is not a finite number > 0, or below {LEAST_RATE}. Author one."
        )
    if not all(map(math.isfinite, codes)):
        raise BadValue(f"{_file(stage)}: startTimeCode and endTimeCode {codes} are not finite. Author finite numbers.")
    if max(map(abs, codes)) > MOST_SECONDS * rate:
        raise BadValue(
            f"{_file(stage)}: startTimeCode and endTimeCode {codes} are more than {MOST_SECONDS:g} s from 0 at "
            f"timeCodesPerSecond {rate}. Author others."
        )
    # Older files say startFrame and endFrame, which only the second asks for, as a pair.
    has_end = stage.HasAuthoredMetadata("endTimeCode") or stage.HasAuthoredTimeCodeRange()
    return StageTimes(rate, *(codes if has_end else (None, None)))


def set_rate(stage: Usd.Stage, rate: float) -> None:
    """Author the time codes per second of a stage on its root layer, unless they are these already."""
    if stage.GetTimeCodesPerSecond() != rate:
        with Usd.EditContext(stage, stage.GetRootLayer()):
            stage.SetTimeCodesPerSecond(rate)


def _file(stage: Usd.Stage) -> str:
    layer = stage.GetRootLayer()
    return layer.realPath or layer.identifier
