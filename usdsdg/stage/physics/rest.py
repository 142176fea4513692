"""What is said of bodies that did not come to rest."""

from collections.abc import Sequence

from usdsdg.errors import counted

_NAMED = 5


def still_moving(paths: Sequence[str], max_time: float) -> str:
    """Return the sentence on the bodies that still move after `max_time` [s]; it names the first of them."""
    more = len(paths) - _NAMED
    shown = ", ".join(paths[:_NAMED]) + (f" and {more} more" if more > 0 else "")
    return (
        f"{counted(len(paths), 'body still moves', 'bodies still move')} after {max_time:g} s: {shown}. Give them more "
        "time, or look for bodies that fall past the floor, or that no space is left for."
    )
