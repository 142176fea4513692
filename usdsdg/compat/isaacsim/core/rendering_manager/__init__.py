"""`isaacsim.core.rendering_manager`: app updates without physics, and cameras of viewports."""

from usdsdg.compat.isaacsim.core.rendering_manager.rendering_manager import RenderingEvent, RenderingManager
from usdsdg.compat.isaacsim.core.rendering_manager.viewport_manager import ViewportManager

__all__ = ["RenderingEvent", "RenderingManager", "ViewportManager"]
