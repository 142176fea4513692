"""`omni.timeline`: the clock."""

from usdsdg.timeline import Timeline as ITimeline
from usdsdg.timeline import get_timeline


def get_timeline_interface(name: str = "") -> ITimeline:
    return get_timeline()


acquire_timeline_interface = get_timeline_interface
