"""`omni.isaac.kit.utils`: settings and stages, as standalone scripts have them at hand."""

from typing import Any

from usdsdg.compat.carb import settings
from usdsdg.compat.isaacsim.core.utils.stage import create_new_stage, is_stage_loading, open_stage, save_stage

__all__ = ["create_new_stage", "is_stage_loading", "open_stage", "save_stage", "set_carb_setting"]


def set_carb_setting(carb_settings: Any, setting: str, value: Any) -> None:
    """Set a setting; `carb_settings` is what `carb.settings.get_settings()` returns."""
    (carb_settings or settings.get_settings()).set(setting, value)
