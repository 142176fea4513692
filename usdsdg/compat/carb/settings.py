"""`carb.settings`: the settings store."""

from usdsdg.session.settings.store import ChangeEventType, get_settings
from usdsdg.session.settings.store import Settings as ISettings

acquire_settings_interface = get_settings_interface = get_settings
SubscriptionId = int

__all__ = [
    "ChangeEventType", "ISettings", "SubscriptionId", "acquire_settings_interface", "get_settings",
    "get_settings_interface",
]  # fmt: skip
