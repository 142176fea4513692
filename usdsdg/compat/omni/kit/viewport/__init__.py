"""`omni.kit.viewport`: in Isaac Sim 2021 what is `omni.kit.viewport_legacy` afterward."""

from usdsdg.compat.omni.kit.viewport_legacy import (
    acquire_viewport_interface,
    get_default_viewport_window,
    get_viewport_interface,
)

__all__ = ["acquire_viewport_interface", "get_default_viewport_window", "get_viewport_interface"]
