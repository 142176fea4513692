"""`isaacsim.simulation_app`: the application that a standalone script starts and closes."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Coroutine
from typing import Any

from usdsdg import orchestrator
from usdsdg.app.app import App, get_app
from usdsdg.compat import kit_arguments
from usdsdg.compat.isaacsim.app_framework import AppFramework as AppFramework
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings

# The render modes in any case, and the short name of one.
_RENDERERS = {
    name.lower(): name for name in ("RaytracedLighting", "PathTracing", "RealTimePathTracing", "MinimalRendering")
} | {"minimal": "MinimalRendering"}
# Settings of entries of the launch configuration.
_SETTINGS = {
    "width": ("/app/renderer/resolution/width",),
    "height": ("/app/renderer/resolution/height",),
    "window_width": ("/app/window/width",),
    "window_height": ("/app/window/height",),
    "samples_per_pixel_per_frame": ("/rtx/pathtracing/spp", "/rtx/pathtracing/totalSpp"),
    "denoiser": ("/rtx/pathtracing/optixDenoiser/enabled",),
    "max_bounces": ("/rtx/pathtracing/maxBounces",),
    "max_specular_transmission_bounces": ("/rtx/pathtracing/maxSpecularAndTransmissionBounces",),
    "max_volume_bounces": ("/rtx/pathtracing/maxVolumeBounces",),
    "anti_aliasing": ("/rtx/post/aa/op",),
    "subdiv_refinement_level": ("/rtx/hydra/subdivision/refinementLevel",),
}


class SimulationApp:
    """The running application, without a window.

    Of `launch_config` these have an effect: "renderer", the render mode; "samples_per_pixel_per_frame", "denoiser",
    "max_bounces" and "max_specular_transmission_bounces" for path tracing; "width" and "height" of the viewport;
    "open_usd", a stage to open; "create_new_stage", false to keep the current stage; "extra_args", a list of Kit's
    arguments. Kit's arguments in sys.argv count too. Others, and the experience file, concern windows and Kit itself.

    Raises:
        AssetError: the stage of "open_usd" is missing or cannot be read.
    """

    DEFAULT_LAUNCHER_CONFIG: dict[str, Any] = {
        "headless": True, "hide_ui": None, "active_gpu": None, "physics_gpu": 0, "multi_gpu": True,
        "max_gpu_count": None, "sync_loads": True, "width": 1280, "height": 720, "window_width": 1440,
        "window_height": 900, "display_options": 3094, "subdiv_refinement_level": 0, "renderer": "RealTimePathTracing",
        "anti_aliasing": 3, "samples_per_pixel_per_frame": 64, "denoiser": True, "max_bounces": 3,
        "max_specular_transmission_bounces": 6, "max_volume_bounces": 15, "open_usd": None, "fast_shutdown": True,
        "profiler_backend": [], "create_new_stage": True, "extra_args": [], "disable_viewport_updates": False,
    }  # fmt: skip

    def __init__(self, launch_config: dict[str, Any] | None = None, experience: str = "") -> None:
        self._given = dict(launch_config or {})
        self.config = {**self.DEFAULT_LAUNCHER_CONFIG, **self._given}
        self.reset_render_settings()
        extra = self.config["extra_args"]
        kit_arguments.apply([*(extra if isinstance(extra, list) else []), *sys.argv[1:]])
        current().viewport.resolution = (int(self.config["width"]), int(self.config["height"]))
        get_app().open_loop()
        if self.config["open_usd"] is not None:
            stage_context.open_stage(self.config["open_usd"])
        elif self.config["create_new_stage"]:
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

    def reset_render_settings(self) -> None:
        """Set the render settings again that the launch configuration gives."""
        settings = get_settings()
        if "renderer" in self._given:
            renderer = str(self._given["renderer"])
            settings.set("/rtx/rendermode", _RENDERERS.get(renderer.lower(), renderer))
        for name, keys in _SETTINGS.items():
            for key in keys if name in self._given else ():
                settings.set(key, self._given[name])

    def close(self, wait_for_replicator: bool = True, skip_cleanup: bool = False, exit_code: int = 0) -> None:
        """Wait for all files and end the app, not for tasks that still run. An `exit_code` other than 0 exits."""
        orchestrator.wait_until_complete()
        get_app().close()
        if exit_code:
            sys.exit(exit_code)
