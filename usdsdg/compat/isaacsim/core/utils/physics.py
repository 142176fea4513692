"""`isaacsim.core.utils.physics`: whether bodies move, and the play of a number of seconds."""

from __future__ import annotations

from collections.abc import Callable

from usdsdg.app.app import get_app
from usdsdg.compat.wrappers.prim_paths import existing_prim

__all__ = ["get_rigid_body_enabled", "set_rigid_body_enabled", "simulate_async"]

_ENABLED = "physics:rigidBodyEnabled"


def get_rigid_body_enabled(prim_path: str) -> bool | None:
    """Return whether a rigid body is moved by forces; None for a prim that is none.

    Raises:
        BadPrim: there is no such prim.
    """
    return existing_prim(prim_path).GetAttribute(_ENABLED).Get()


def set_rigid_body_enabled(_value: bool, prim_path: str) -> None:
    """Let forces move a rigid body, or not; a prim that is none stays as it is.

    Raises:
        BadPrim: there is no such prim.
    """
    if enabled := existing_prim(prim_path).GetAttribute(_ENABLED):
        enabled.Set(bool(_value))


async def simulate_async(seconds: float, steps_per_sec: int = 60, callback: Callable[..., None] | None = None) -> None:
    """Update the application for `seconds * steps_per_sec` frames; after each comes `callback()`.

    As in Isaac Sim, the timeline is left as it is: scripts play it before.
    """
    for _ in range(round(steps_per_sec * seconds)):
        await get_app().next_update_async()
        if callback is not None:
            callback()
