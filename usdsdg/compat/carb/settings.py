"""`carb.settings`: the settings tree."""

from usdsdg.settings import Settings as ISettings
from usdsdg.settings import get_settings

acquire_settings_interface = get_settings

__all__ = ["ISettings", "acquire_settings_interface", "get_settings"]
