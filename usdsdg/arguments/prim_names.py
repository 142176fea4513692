"""Names that scripts give to new prims."""

from typing import Any

from usdsdg.errors import warn_once
from usdsdg.stage.paths import valid_name


def prim_name(name: Any) -> str:
    """Return the name that a prim gets: characters that USD does not allow are underscores, with a warning."""
    valid = valid_name(str(name))
    if valid != name:
        warn_once(f"{name!r} cannot be the name of a prim; it is called {valid} instead")
    return valid
