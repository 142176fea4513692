"""The version of Replicator whose payloads scripts expect."""

from usdsdg.errors import BadValue
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings

KEY = "/usdsdg/replicator/version"
OLD, NEW = 4, 6
AUTOMATIC = 0


def replicator_version() -> int:
    """Return 4 or 6: the setting `/usdsdg/replicator/version`, or, where that is 0, what the script tells.

    Version 4 is that of Isaac Sim 4, in which colorized segmentation is uint32 (H, W), one packed RGBA per pixel.

    Raises:
        BadValue: the setting has another value.
    """
    chosen = get_settings().get(KEY)
    if chosen not in (AUTOMATIC, OLD, NEW):
        raise BadValue(f"{KEY} is {chosen!r}; expected {OLD}, {NEW}, or {AUTOMATIC} for what the script imports")
    return chosen or current().imported_version or NEW


def note_old_import() -> None:
    """Note that the script has imported a module that only Isaac Sim 4 has, or reads colors as that gives them."""
    current().imported_version = OLD
