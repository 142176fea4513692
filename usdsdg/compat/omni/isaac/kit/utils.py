"""`omni.isaac.kit.utils`: settings, as scripts of Isaac Sim 2021 and 2022 set them."""

from typing import Any

from usdsdg.compat.carb import settings

__all__ = ["set_carb_setting"]


def set_carb_setting(carb_settings: Any, setting: str, value: Any) -> None:
    """Set a setting; `carb_settings` is what `carb.settings.get_settings()` returns."""
    (carb_settings or settings.get_settings()).set(setting, value)
