"""`isaacsim.storage.native`: the assets root, and what is a file or a folder."""

from usdsdg.compat.omni.isaac import nucleus
from usdsdg.compat.omni.isaac.nucleus import *  # noqa: F403 - the same functions

__all__ = nucleus.__all__  # pyright: ignore[reportUnsupportedDunderAll]
