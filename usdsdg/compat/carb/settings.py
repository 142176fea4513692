"""`carb.settings`: the settings store."""

from usdsdg.session.settings_store import Settings as ISettings
from usdsdg.session.settings_store import get_settings

acquire_settings_interface = get_settings

__all__ = ["ISettings", "acquire_settings_interface", "get_settings"]
