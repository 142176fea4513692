"""The user's cache folder, where demo assets, stand-ins and mirrored assets are kept."""

import os
from pathlib import Path


def cache_folder() -> Path:
    """Return `$XDG_CACHE_HOME/usdsdg`, by default `~/.cache/usdsdg`; it need not exist yet."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(cache) / "usdsdg"
