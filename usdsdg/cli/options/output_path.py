"""Paths of files and folders that commands write."""

import os
from pathlib import Path

from usdsdg.errors import OutputNotWritable


def output_path(given: Path) -> Path:
    """Return a path with the user's home folder in place of `~`, which shells leave as it is in quotes.

    Raises:
        OutputNotWritable: it is a URL, of which a path would be a folder called `s3:`.
    """
    from usdsdg.stage.assets.url import scheme_of

    if scheme_of(os.fspath(given)):
        url = os.fspath(given).replace(":/", "://", 1)  # of which a path keeps one slash
        raise OutputNotWritable(f"{url} is a URL, and this is written to a path on this machine; give one")
    return Path(os.path.expanduser(given))
