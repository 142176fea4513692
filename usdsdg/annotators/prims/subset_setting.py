"""The setting that makes GeomSubsets gprims of their own in labels."""

from usdsdg.session.settings.store import get_settings

SETTING = "/syntheticdata/sensors/perSubsetSegmentation"


def subsets_are_told_apart() -> bool:
    """Return whether labels tell the GeomSubsets of a mesh apart."""
    return get_settings().get_as_bool(SETTING)
