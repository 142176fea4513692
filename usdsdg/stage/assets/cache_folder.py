"""The user's cache folder, where demo assets, stand-ins and mirrored assets are kept."""

import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path


def cache_folder() -> Path:
    """Return `$XDG_CACHE_HOME/usdsdg`, by default `~/.cache/usdsdg`; it need not exist yet."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(cache) / "usdsdg"


def built_folder(target: Path, build: Callable[[Path], None]) -> Path:
    """Return `target`, filled by `build(folder)` if there is no such folder yet: whole, or not at all.

    Processes that build at the same time each make a copy of their own, and the first one to finish is kept.

    Raises:
        OSError: it cannot be written.
    """
    if target.is_dir():
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        build(temporary)
        temporary.chmod(0o755)
        temporary.rename(target)
    except OSError:
        # Another process may have finished first; its folder has the same contents.
        if not target.is_dir():
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return target
