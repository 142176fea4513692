"""`isaacsim.core.utils.carb`: settings."""

from typing import Any

from usdsdg.session.settings.store import Settings


def set_carb_setting(carb_settings: Settings, setting: str, value: Any) -> None:
    carb_settings.set(setting, value)


def get_carb_setting(carb_settings: Settings, setting: str) -> Any:
    return carb_settings.get(setting)
