"""Foreign import names: `omni.*`, `carb`, `usdrt`, `isaacsim`, `pxr.PhysxSchema`, for scripts written for Isaac Sim.

`install()` makes them importable in this process; nothing else in the process changes.
"""

from usdsdg.compat.finder import install, is_installed

__all__ = ["install", "is_installed"]
