"""Set samples of what is simulated aside, which would be drawn instead of the values that steps write."""

from pxr import Usd

from usdsdg.errors import warn_once
from usdsdg.stage.time_code import default_or_current_time, is_sampled
from usdsdg_physics.writeback.restore import Backup, attribute_spec


def freeze(attribute: Usd.Attribute, target: Usd.EditTarget, backup: Backup) -> None:
    """Give an attribute that has samples, a spline or value clips one value at all times, until the backup is restored.

    It is a default value beside the samples, and without one the value at the time of the context. Samples that a
    script makes afterward, as a record of the simulation, stay.
    """
    if not is_sampled(attribute):
        return
    if not backup.keep(target.GetLayer(), target.MapToSpecPath(attribute.GetPath())):
        return
    value = attribute.Get(default_or_current_time(attribute))
    spec = attribute_spec(target, attribute)
    backup.set_aside(spec, value)
    if is_sampled(attribute):
        warn_once(
            f"{attribute.GetPath()} is simulated but will not show: a layer that is stronger than the edit target, "
            f"{target.GetLayer().identifier}, has samples of it. Remove these, or edit in that layer."
        )
