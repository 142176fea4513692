"""`omni.isaac.python_app`: the application of standalone scripts of Isaac Sim 2020 and 2021."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Gf, Usd

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.simulation_manager.physics_scene import PhysicsScene
from usdsdg.compat.isaacsim.core.utils.prims import create_prim
from usdsdg.compat.isaacsim.core.utils.stage import set_stage_up_axis
from usdsdg.compat.isaacsim.simulation_app import SimulationApp
from usdsdg.compat.omni.kit import commands
from usdsdg.compat.omni.usd import UsdContext, get_context
from usdsdg.session.timeline import get_timeline

__all__ = ["OmniKitHelper"]


class OmniKitHelper:
    """The running application. Keys of `config` that `SimulationApp` ignores are ignored here, too."""

    DEFAULT_CONFIG: dict[str, Any] = {
        "width": 1024, "height": 800, "renderer": "PathTracing", "samples_per_pixel_per_frame": 64, "denoiser": True,
        "max_bounces": 4, "max_specular_transmission_bounces": 6, "max_volume_bounces": 4,
    }  # fmt: skip

    def __init__(self, config: Mapping[str, Any] | None = None) -> None:
        self.simulation_app = SimulationApp({**self.DEFAULT_CONFIG, **(config or {})})
        self.config = self.simulation_app.config
        self.app, self.timeline = get_app(), get_timeline()

    def get_stage(self) -> Usd.Stage:
        return get_context().get_stage()

    def get_context(self) -> UsdContext:
        return get_context()

    def set_setting(self, setting: str, value: Any) -> None:
        self.simulation_app.set_setting(setting, value)

    def set_physics_dt(self, physics_dt: float = 1 / 60, physics_substeps: int | None = 1) -> None:
        """Set the length of physics steps [s] of the PhysicsScenes that the stage has.

        Raises:
            ValueError: it is not within 0 and 1.
        """
        for path in PhysicsScene.get_physics_scene_paths():
            PhysicsScene(path).set_dt(physics_dt)

    def update(
        self, dt: float | None = 0.0, physics_dt: float | None = None, physics_substeps: int | None = None
    ) -> None:
        """Run an application update of `dt` seconds, with physics steps as long as that or `physics_dt`.

        0 or None: an update of one time code, since none follows a clock.
        """
        step = dt if physics_dt is None else physics_dt
        if step is not None and step > 0.0:
            self.set_physics_dt(step, physics_substeps)
        get_app().set_seconds_of_update(dt or None)
        try:
            get_app().update()
        finally:
            get_app().set_seconds_of_update(None)

    def play(self) -> None:
        """Play the timeline, with an update before and one after."""
        self._command(get_timeline().play)

    def pause(self) -> None:
        """Pause the timeline, with an update before and one after."""
        self._command(get_timeline().pause)

    def stop(self) -> None:
        """Stop the timeline, with an update before and one after."""
        self._command(get_timeline().stop)

    def get_status(self) -> tuple[str, int, int]:
        """Return what is being loaded: nothing, since files are read at once."""
        return get_context().get_stage_loading_status()

    def is_loading(self) -> bool:
        return self.get_status()[2] > 0

    def is_exiting(self) -> bool:
        return self.simulation_app.is_exiting()

    def execute(self, *args: Any, **kwargs: Any) -> None:
        """Run a command of Kit by its name."""
        commands.execute(*args, **kwargs)

    def setup_renderer(self, mode: str = "non-default") -> None:
        """Set the render settings again that `config` gives."""
        self.simulation_app.reset_render_settings()

    def create_prim(
        self,
        path: str,
        prim_type: str,
        translation: Sequence[float] | None = None,
        rotation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        ref: str | None = None,
        semantic_label: str | None = None,
        attributes: Mapping[str, Any] | None = None,
    ) -> Usd.Prim:
        """Define a prim, reference the file `ref` on it, label and place it.

        rotation: [degrees] about x, y and z, in this order.

        Raises:
            AssetError: the file is missing.
            ValueError: there is a prim already.
        """
        turned = Gf.Rotation(Gf.Vec3d(1, 0, 0), 0)
        for axis, angle in zip(np.eye(3), rotation or ()):
            turned *= Gf.Rotation(Gf.Vec3d(*axis.tolist()), float(angle))
        quaternion = turned.GetQuat()
        return create_prim(
            path,
            prim_type,
            translation=translation,
            orientation=None if rotation is None else (quaternion.GetReal(), *quaternion.GetImaginary()),
            scale=scale,
            usd_path=ref,
            semantic_label=semantic_label,
            attributes=attributes,
        )

    def set_up_axis(self, axis: str) -> None:
        """Set the up axis of the stage: "X", "Y" or "Z"."""
        set_stage_up_axis(str(axis).lower())

    def shutdown(self) -> None:
        """Wait for all files and end the application."""
        self.simulation_app.close()

    def _command(self, command: Callable[[], None]) -> None:
        get_app().update()
        command()
        get_app().update()
