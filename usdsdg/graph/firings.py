"""Which of the next frames the nodes of a trigger run in, and how often they have run by then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.errors import Unsupported
from usdsdg.graph.evaluate import Trigger

REMEDY = "Leave it out, or run without worlds."


@dataclass(frozen=True)
class Firings:
    """The firings of a trigger in some frames that follow each other.

    Attributes:
        fires: (frames,) bool, in which frames it fires.
        cadence: equal for triggers that have fired in the same frames so far, and will.
    """

    trigger: Trigger
    fires: np.ndarray
    cadence: tuple[int, ...]

    @staticmethod
    def of(trigger: Trigger, frames: np.ndarray) -> Firings:
        """Return the firings of a trigger, as it is before the first of the frames.

        Raises:
            Unsupported: the trigger does not fire by frames.
        """
        if trigger.kind != "OgnOnFrame":
            raise Unsupported(f"worlds: {trigger.node.describe()} does not fire by frames, as worlds need. {REMEDY}")
        if any(node.is_off for node in (trigger.node, *trigger.nodes)):
            raise Unsupported(f"worlds: a node of {trigger.node.describe()} is disabled. {REMEDY}")
        interval = int(trigger.node.inputs["interval"])
        # The preview has drawn what frame 0 shows.
        fires = (frames > 0) & (frames % interval == 0)
        if trigger.max_execs > 0:
            remaining = max(trigger.max_execs - (trigger.executions - trigger.counted_from), 0)
            fires &= np.cumsum(fires) <= remaining
        return Firings(trigger, fires, (interval, trigger.max_execs, trigger.executions, trigger.counted_from))

    def exhausts(self) -> np.ndarray:
        """(frames,) bool, after which frames it has reached its limit; False where it has none."""
        fired = self.trigger.executions - self.trigger.counted_from + np.cumsum(self.fires)
        return (fired >= self.trigger.max_execs) & (self.trigger.max_execs > 0)

    @property
    def is_steady(self) -> bool:
        """Whether it fires in every frame, also in those that follow."""
        return self.cadence[:2] == (1, 0)

    def later(self) -> np.ndarray:
        """(frames,) how often it has fired since the first frame, that one left out."""
        return np.cumsum(self.fires) - int(self.fires[0])


def frames_until_exhausted(triggers: Sequence[Trigger], frame: int, count: int) -> int:
    """Return after how many of `count` frames, the first being `frame`, all triggers have reached their limits.

    That is `count` where they do not, and 1 where they have before.

    Raises:
        Unsupported: a trigger does not fire by frames.
    """
    frames = frame + np.arange(count)
    exhausted = np.all([Firings.of(trigger, frames).exhausts() for trigger in triggers], axis=0)
    return int(np.argmax(exhausted)) + 1 if exhausted.any() else count
