"""The time metadata of a stage: its time codes per second, and the range of its animation."""

import math
from typing import NamedTuple

from pxr import Usd

from usdsdg.errors import BadValue


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
        BadValue: its time codes are not finite, or their rate is not above 0.
    """
    rate, codes = stage.GetTimeCodesPerSecond(), (stage.GetStartTimeCode(), stage.GetEndTimeCode())
    if not (math.isfinite(rate) and rate > 0.0):
        raise BadValue(f"{_file(stage)}: timeCodesPerSecond {rate} is not a finite number > 0. Author one.")
    if not all(map(math.isfinite, codes)):
        raise BadValue(f"{_file(stage)}: startTimeCode and endTimeCode {codes} are not finite. Author finite numbers.")
    return StageTimes(rate, *(codes if stage.HasAuthoredMetadata("endTimeCode") else (None, None)))


def set_rate(stage: Usd.Stage, rate: float) -> None:
    """Author the time codes per second of a stage on its root layer, unless they are these already."""
    if stage.GetTimeCodesPerSecond() != rate:
        with Usd.EditContext(stage, stage.GetRootLayer()):
            stage.SetTimeCodesPerSecond(rate)


def _file(stage: Usd.Stage) -> str:
    layer = stage.GetRootLayer()
    return layer.realPath or layer.identifier
