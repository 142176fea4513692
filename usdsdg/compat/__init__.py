"""Import names of Isaac Sim and Omniverse: `omni.*`, `carb`, `usdrt`, `isaacsim`, `pxr.PhysxSchema`.

`install()` makes them importable in this process, so that scripts written for Isaac Sim run unchanged.
"""

from usdsdg.compat.finder import install, is_installed

__all__ = ["install", "is_installed"]
