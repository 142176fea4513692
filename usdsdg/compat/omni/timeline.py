"""`omni.timeline`: the timeline and the names of its events."""

import enum

from usdsdg.compat.carb.eventdispatcher import TIMELINE_EVENTS
from usdsdg.session.timeline import Timeline as ITimeline
from usdsdg.session.timeline import get_timeline


class TimelineEventType(enum.IntEnum):
    """The types of events in `get_timeline_event_stream`; of the others there are none."""

    PLAY = 0
    PAUSE = 1
    STOP = 2
    CURRENT_TIME_CHANGED = 3
    CURRENT_TIME_TICKED = 4
    LOOPED = 5


def get_timeline_interface(name: str = "") -> ITimeline:
    return get_timeline()


acquire_timeline_interface = get_timeline_interface

GLOBAL_EVENT_PLAY = TIMELINE_EVENTS["play"]
GLOBAL_EVENT_PAUSE = TIMELINE_EVENTS["pause"]
GLOBAL_EVENT_STOP = TIMELINE_EVENTS["stop"]
GLOBAL_EVENT_LOOPED = TIMELINE_EVENTS["loop"]
GLOBAL_EVENT_CURRENT_TIME_TICKED = TIMELINE_EVENTS["tick"]
