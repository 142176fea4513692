"""`omni.timeline`: the timeline and the names of its events."""

import enum

from usdsdg.compat.carb.eventdispatcher import TICKED_PERMANENT, TIMELINE_EVENTS
from usdsdg.session.timeline import Timeline as ITimeline
from usdsdg.session.timeline import get_timeline


class TimelineEventType(enum.IntEnum):
    """The types of events in `get_timeline_event_stream`; those of 5 to 16 are never sent.

    LOOPED, which Kit does not have, is sent where a timeline that loops begins again.
    """

    PLAY = 0
    PAUSE = 1
    STOP = 2
    CURRENT_TIME_CHANGED = CURRENT_TIME_TICKED_PERMANENT = 3
    CURRENT_TIME_TICKED = 4
    LOOP_MODE_CHANGED = 5
    START_TIME_CHANGED = 6
    END_TIME_CHANGED = 7
    TIME_CODE_PER_SECOND_CHANGED = 8
    AUTO_UPDATE_CHANGED = 9
    PREROLLING_CHANGED = 10
    TENTATIVE_TIME_CHANGED = 11
    TICKS_PER_FRAME_CHANGED = 12
    FAST_MODE_CHANGED = PLAY_EVERY_FRAME_CHANGED = 13
    TARGET_FRAMERATE_CHANGED = 14
    DIRECTOR_CHANGED = 15
    ZOOM_CHANGED = 16
    LOOPED = 100


def get_timeline_interface(name: str = "") -> ITimeline:
    return get_timeline()


acquire_timeline_interface = get_timeline_interface

GLOBAL_EVENT_PLAY = TIMELINE_EVENTS["play"]
GLOBAL_EVENT_PAUSE = TIMELINE_EVENTS["pause"]
GLOBAL_EVENT_STOP = TIMELINE_EVENTS["stop"]
GLOBAL_EVENT_LOOPED = TIMELINE_EVENTS["loop"]
GLOBAL_EVENT_CURRENT_TIME_TICKED = TIMELINE_EVENTS["tick"]
GLOBAL_EVENT_CURRENT_TIME_TICKED_PERMANENT = TICKED_PERMANENT
