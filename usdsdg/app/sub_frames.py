"""How many sub-frames the next capture has. Mirrors `rep.orchestrator.set_next_rt_subframes` and its like."""

from usdsdg.graph.evaluate import Trigger
from usdsdg.session.settings.store import get_settings


class SubFrames:
    """The number that scripts have set for the next capture, which that uses up."""

    def __init__(self) -> None:
        self._next = 0
        self.of_step = 0  # what the latest `step` asked for

    def reset(self) -> None:
        self._next = self.of_step = 0

    def set_next(self, count: int) -> None:
        """Render the next frame with `count` sub-frames, or with as many as the setting and triggers ask for."""
        self._next = int(count)

    def set_minimum(self, count: int) -> None:
        """Render the next frame with at least `count` sub-frames."""
        self._next = max(self._next, int(count))

    def take(self, of_step: int, fired: list[Trigger]) -> int:
        """Return the number for a frame; `of_step`, where it is above 0, counts instead of what was set before."""
        asked = of_step if of_step > 0 else self._next
        self._next = 0
        setting = get_settings().get_as_int("/omni/replicator/RTSubframes")
        return max([asked, setting, *(trigger.rt_subframes for trigger in fired), 1])
