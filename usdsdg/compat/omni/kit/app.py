"""`omni.kit.app`: the application."""

from usdsdg.app import App as IApp
from usdsdg.app import get_app

get_app_interface = get_app

__all__ = ["IApp", "get_app", "get_app_interface"]
