"""`isaacsim.core.api.scenes`: the objects of a world, by name."""

from usdsdg.compat.isaacsim.core.api.scenes.scene import Scene

__all__ = ["Scene"]
