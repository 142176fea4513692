"""`omni.kit.app`: the application."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from usdsdg.app.app import App as IApp
from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import APP_UPDATE as GLOBAL_EVENT_UPDATE
from usdsdg.compat.carb.events import POST_QUIT_EVENT_TYPE, PRE_SHUTDOWN_EVENT_TYPE, ISubscription
from usdsdg.session.settings.store import ChangeEventType, get_settings

get_app_interface = get_app

__all__ = [
    "GLOBAL_EVENT_UPDATE", "POST_QUIT_EVENT_TYPE", "PRE_SHUTDOWN_EVENT_TYPE", "IApp", "SettingChangeSubscription",
    "get_app", "get_app_interface",
]  # fmt: skip


class SettingChangeSubscription(ISubscription):
    """Calls `on_change(value, event type)` whenever a setting is set, while it is held."""

    def __init__(self, path: str, on_change: Callable[[Any, ChangeEventType], Any]) -> None:
        settings = get_settings()
        number = settings.subscribe_to_node_change_events(path, on_change)
        super().__init__(partial(settings.unsubscribe_to_change_events, number))
