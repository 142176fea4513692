"""`omni.kit.app`: the application."""

from usdsdg.app.app import App as IApp
from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import APP_UPDATE as GLOBAL_EVENT_UPDATE

get_app_interface = get_app

__all__ = ["GLOBAL_EVENT_UPDATE", "IApp", "get_app", "get_app_interface"]
