"""`isaacsim.simulation_app`: the application that a standalone script starts and closes."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

from usdsdg import orchestrator
from usdsdg.app.app import App, get_app
from usdsdg.session import stage_context
from usdsdg.session.settings_store import get_settings


class SimulationApp:
    """The running application; of `launch_config` only "renderer", the render mode, has an effect."""

    def __init__(self, launch_config: dict[str, Any] | None = None, experience: str = "") -> None:
        self.config = dict(launch_config or {})
        if "renderer" in self.config:
            get_settings().set("/rtx/rendermode", self.config["renderer"])
        get_app().open_loop()
        stage_context.stage_at_start()

    @property
    def app(self) -> App:
        return get_app()

    @property
    def context(self) -> Any:
        from usdsdg.compat.omni.usd import get_context

        return get_context()

    def update(self) -> None:
        get_app().update()

    def run_coroutine(self, coroutine: Coroutine[Any, Any, Any], run_until_complete: bool = True) -> Any:
        """Return the coroutine's result, or its task if `run_until_complete` is false."""
        if run_until_complete:
            return get_app().run_until_complete(coroutine)
        return asyncio.ensure_future(coroutine)

    def is_running(self) -> bool:
        return get_app().is_running()

    def is_exiting(self) -> bool:
        return not self.is_running()

    def set_setting(self, setting: str, value: Any) -> None:
        get_settings().set(setting, value)

    def close(self, wait_for_replicator: bool = True, skip_cleanup: bool = False, exit_code: int = 0) -> None:
        """Wait for all files and end the app; tasks that still run are not waited for."""
        orchestrator.wait_until_complete()
        get_app().close()
