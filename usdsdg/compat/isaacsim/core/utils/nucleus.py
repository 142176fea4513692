"""`isaacsim.core.utils.nucleus`: the assets root."""

from usdsdg.compat.omni.isaac.nucleus import get_assets_root_path, get_assets_root_path_async

__all__ = ["get_assets_root_path", "get_assets_root_path_async"]
