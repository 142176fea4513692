"""The base class of scripts on prims."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pxr import Sdf, Usd

from usdsdg.app.app import App, get_app
from usdsdg.session import stage_context
from usdsdg.session.settings.store import Settings, get_settings
from usdsdg.session.timeline import Timeline, get_timeline

if TYPE_CHECKING:
    from usdsdg.compat.omni.usd import UsdContext


class BehaviorScript:
    """A script on one prim; subclasses override the methods that are called while the application runs.

    The prim's attribute `omni:scripting:scripts` names the Python file, as `ApplyScriptingAPICommand` creates it.
    """

    def __init__(self, prim_path: Sdf.Path | str) -> None:
        self._prim_path = Sdf.Path(str(prim_path))
        self._stage = stage_context.current_stage()

    # --- what is called ---
    def on_init(self) -> None:
        """Called when the script is attached to the prim."""

    def on_destroy(self) -> None:
        """Called when the script is taken off the prim, or another stage is opened."""

    def on_play(self) -> None:
        """Called when the timeline begins to play, also after a pause."""

    def on_pause(self) -> None:
        """Called when the timeline pauses."""

    def on_stop(self) -> None:
        """Called when the timeline stops."""

    def on_update(self, current_time: float, delta_time: float) -> None:
        """Called whenever a playing timeline has advanced: to `current_time` [s], by `delta_time` [s]."""

    # --- where the script is ---
    @property
    def prim_path(self) -> Sdf.Path:
        return self._prim_path

    @property
    def prim(self) -> Usd.Prim:
        """The prim; invalid if it has been removed, or its stage closed."""
        return self._stage.GetPrimAtPath(self._prim_path) if self._stage else Usd.Prim()

    @property
    def stage(self) -> Usd.Stage:
        """The stage of the prim."""
        return self._stage

    @property
    def usd_context(self) -> UsdContext:
        from usdsdg.compat.omni.usd import get_context

        return get_context()

    @property
    def timeline(self) -> Timeline:
        return get_timeline()

    @property
    def settings(self) -> Settings:
        return get_settings()

    @property
    def app(self) -> App:
        return get_app()
