"""Frames of a run that other processes make, or that were made before, passed over without evaluating the graph."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from usdsdg.app.app import get_app
from usdsdg.app.playback import Playback
from usdsdg.capture.capture import Capture
from usdsdg.capture.time_dependence import may_move
from usdsdg.errors import Unsupported
from usdsdg.graph.evaluate import Trigger, graph, run
from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.worlds import WorldDraws
from usdsdg.session.endings.termination import whole_frame
from usdsdg.session.session import current
from usdsdg.session.settings.store import captures_motion_blur
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.world_values import WorldValues

# So many frames are drawn at once, to see which attributes they change.
_TOGETHER = 64


class FramesOfOthers:
    """Counts the next frames of a run that this process need not evaluate.

    No file of these frames is made here, no writer reads of the stage what they change, the graph alone decides what
    they show, and what a node writes depends on the number of its execution alone: then its last one is enough.
    """

    def __init__(self, capture: Capture, is_unseen: Callable[[], bool]) -> None:
        """is_unseen: whether no code of the script runs between frames."""
        self._capture, self._is_unseen = capture, is_unseen
        self._firing: list[Trigger] = []
        self._are_independent: bool | None = None  # of the frames in which these fire; None: not known
        # Whether some attributes have not changed yet, of which a record tells that they have at one of the frames.
        self._may_change = True

    def count(self, frame: int, last: int | None) -> int:
        """Return how many of the frames from `frame` on can be passed over; the stage shows the frame before.

        last: the frame before which the run ends; None: triggers end it, as soon as they have reached their limits.
        """
        if not self._is_unseen() or graph().impulses:
            return 0
        firing = [trigger for trigger in graph().triggers if not trigger.exhausted]
        count = self._capture.count_unwanted(frame, _most(firing, frame, last))
        if count and (firing != self._firing or self._are_independent is None):
            self._firing, self._are_independent, self._may_change = firing, None, True
            if not _graph_decides(firing):
                self._are_independent = False
        if not count or self._are_independent is False:
            return 0
        if self._may_change:
            count = self._look(frame, count)
        return count

    def pass_over(self, frame: int, last: int | None, playback: Playback) -> Iterator[None]:
        """Count the frames from `frame` on that can be passed over; each ends when the next one is asked for.

        last: as for `count`. playback: plays the timeline.
        """
        while not playback.has_ended and (count := self.count(frame, last)):
            end = frame + count
            while frame < end and not playback.has_ended:
                with whole_frame():
                    self.fire(frame, end)
                    playback.play(None, is_first=False, runs=True)
                    if seconds := playback.duration(None):
                        get_app().advance(seconds)
                    self._capture.pass_over(frame)
                    frame += 1
                    yield

    def fire(self, frame: int, end: int) -> None:
        """Count the firings of one frame; `end` is the next one that is not passed over.

        What is not written there again is written now.
        """
        for trigger in self._firing:
            interval = int(trigger.node.inputs["interval"])
            if frame % interval:
                continue
            trigger.executions += 1
            trigger.latest = frame
            for node in trigger.nodes:
                if interval > 1 and frame + interval >= end:
                    run(node)
                else:
                    node.executions += 1

    def _look(self, frame: int, count: int) -> int:
        """Draw the next frames, for what records tell of them; return how many may be passed over, of `count`."""
        drawn = min(count, _TOGETHER)
        values = _draws(frame - 1, drawn + 1)
        self._are_independent = values is not None and not self._capture.has_to_see(values)
        if values is None or not self._are_independent:
            return 0
        self._may_change = self._capture.follow_unseen(values)
        return drawn if self._may_change else count


def _most(firing: list[Trigger], frame: int, last: int | None) -> int:
    """Return how many frames may be passed over at most: not the last one, nor that of the last firing of a trigger.

    The stage shows these afterward.
    """
    ends = [trigger.max_execs - (trigger.executions - trigger.counted_from) for trigger in firing if trigger.max_execs]
    if last is not None:
        ends.append(last - frame)
    return max(min(ends, default=0) - 1, 0)


def _graph_decides(firing: list[Trigger]) -> bool:
    """Return whether all triggers fire by frames, and nothing else changes what these show."""
    engines = current().engines
    if captures_motion_blur() or engines.step_listeners or engines.step_listeners_before or may_move(current_stage()):
        return False
    if any(isinstance(node.prims, LivePrims) for trigger in firing for node in trigger.nodes):
        return False  # what is found depends on what the frame before shows
    return all(trigger.kind == "OgnOnFrame" and trigger.prepare is None for trigger in firing)


def _draws(frame: int, count: int) -> WorldValues | None:
    """Return what frames show, from the one on that the stage shows; None where they may depend on each other."""
    try:
        return WorldDraws(graph(), frame, count, is_shown=True).independent_values()
    except Unsupported:
        return None
