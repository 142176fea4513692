"""`RenderingManager`: app updates without physics, and their length."""

from __future__ import annotations

import enum
import itertools
from collections.abc import Callable
from typing import Any, ClassVar

from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import NEW_FRAME, Observer, get_eventdispatcher
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline

_PLAY_SIMULATIONS = "/app/player/playSimulations"


class RenderingEvent(enum.Enum):
    """Events for `RenderingManager.register_callback`."""

    NEW_FRAME = NEW_FRAME


class RenderingManager:
    """Class methods only: there is one application."""

    _observers: ClassVar[dict[int, Observer]] = {}
    _numbers = itertools.count()

    @classmethod
    def render(cls) -> None:
        """Run an app update without physics."""
        settings = get_settings()
        plays = settings.get_as_bool(_PLAY_SIMULATIONS)
        settings.set(_PLAY_SIMULATIONS, False)
        try:
            get_app().update()
        finally:
            settings.set(_PLAY_SIMULATIONS, plays)

    @classmethod
    async def render_async(cls) -> None:
        """Wait for an app update without physics."""
        settings = get_settings()
        plays = settings.get_as_bool(_PLAY_SIMULATIONS)
        settings.set(_PLAY_SIMULATIONS, False)
        try:
            await get_app().next_update_async()
        finally:
            settings.set(_PLAY_SIMULATIONS, plays)

    @classmethod
    def set_dt(cls, dt: float) -> None:
        """Set the length of an app update [s].

        Raises:
            ValueError: it is not positive.
        """
        if dt <= 0:
            raise ValueError(f"an app update of {dt} s is not longer than 0")
        get_timeline().set_time_codes_per_second(1.0 / dt)

    @classmethod
    def get_dt(cls) -> float:
        """Return the length of an app update [s]."""
        return 1.0 / get_timeline().get_time_codes_per_second()

    @classmethod
    def register_callback(cls, event: RenderingEvent, *, callback: Callable[[Any], Any], order: int = 0) -> int:
        """Call `callback(event)` after each frame; return its number."""
        number = next(cls._numbers)
        cls._observers[number] = get_eventdispatcher().observe_event(
            order=order, event_name=event.value, on_event=callback
        )
        return number

    @classmethod
    def deregister_callback(cls, uid: int) -> None:
        observer = cls._observers.pop(uid, None)
        if observer is not None:
            observer.reset()

    @classmethod
    def deregister_all_callbacks(cls) -> None:
        for number in list(cls._observers):
            cls.deregister_callback(number)
