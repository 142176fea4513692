"""The demo assets of the user's cache, for tests that have a cache of their own: to build them takes ten seconds."""

from pathlib import Path

import pytest

from usdsdg.demo.build import root
from usdsdg.stage.assets import cache_folder

# When this is imported, no test has named another one yet.
CACHE = cache_folder().parent


def share_demo_assets(cache: Path) -> None:
    """Link the demo assets into the folder that XDG_CACHE_HOME names, or will name."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(CACHE))
        built = Path(root())
    (cache / "usdsdg").mkdir(parents=True, exist_ok=True)
    (cache / "usdsdg" / built.name).symlink_to(built, target_is_directory=True)
