"""Output paths with `~`, which shells leave as it is in quotes and after `=`."""

import os
from pathlib import Path


def without_tilde(path: Path) -> Path:
    """Return a path with the user's home folder in place of `~`; as it is where there is no such user."""
    return Path(os.path.expanduser(path))
