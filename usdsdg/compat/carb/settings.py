"""`carb.settings`: the settings store."""

from usdsdg.session.settings_store import ChangeEventType, get_settings
from usdsdg.session.settings_store import Settings as ISettings

acquire_settings_interface = get_settings

__all__ = ["ChangeEventType", "ISettings", "acquire_settings_interface", "get_settings"]
