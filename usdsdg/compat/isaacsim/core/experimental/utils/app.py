"""`isaacsim.core.experimental.utils.app`: updates, the timeline and extensions."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.errors import Unsupported
from usdsdg.session.timeline import get_timeline

Callback = Callable[[int, int], bool | None]


def update_app(*, steps: int = 1, callback: Callback | None = None) -> None:
    """Run app updates; `callback(number from 1, steps)` follows each, and ends the loop with False."""
    for number in range(1, steps + 1):
        get_app().update()
        if callback is not None and callback(number, steps) is False:
            return


async def update_app_async(*, steps: int = 1, callback: Callback | None = None) -> None:
    """Wait for app updates; see `update_app`."""
    for number in range(1, steps + 1):
        await get_app().next_update_async()
        if callback is not None and callback(number, steps) is False:
            return


def play(*, commit: bool | None = True) -> None:
    """Play the timeline, at once whether or not `commit`."""
    get_timeline().play()


def pause(*, commit: bool | None = True) -> None:
    """Pause the timeline, at once whether or not `commit`."""
    get_timeline().pause()


def stop(*, commit: bool | None = True) -> None:
    """Stop the timeline, at once whether or not `commit`."""
    get_timeline().stop()


def is_playing() -> bool:
    return get_timeline().is_playing()


def is_paused() -> bool:
    return not (get_timeline().is_playing() or get_timeline().is_stopped())


def is_stopped() -> bool:
    return get_timeline().is_stopped()


def enable_extension(name: str, *, enabled: bool = True) -> bool:
    """Do nothing and return True: there are no extensions, and all that is available is always enabled."""
    return True


def is_extension_enabled(name: str) -> bool:
    """Return True: all that is available is always enabled."""
    return True


def get_extension_id(name: str) -> str | None:
    """Return the name: there are no versions of extensions."""
    return name


def get_extension_dict(name: str) -> dict[str, Any] | None:
    """Return the `extension.toml` of an extension; None of one without a file, as those that usdsdg has."""
    try:
        folder = Path(get_extension_path(name))
    except Unsupported:
        return None
    files = [folder / "config" / "extension.toml", folder / "extension.toml"]
    found = next((file for file in files if file.is_file()), None)
    return None if found is None else tomllib.loads(found.read_text(encoding="utf-8"))


def get_extension_path(name: str) -> str:
    """Return the folder of an extension, as the extension manager does.

    Raises:
        Unsupported: neither a folder of extensions nor usdsdg has it.
    """
    return get_app().get_extension_manager().get_extension_path(name)
