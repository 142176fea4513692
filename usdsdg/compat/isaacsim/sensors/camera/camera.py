"""`Camera`: a camera prim with its pose, lens and images."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.api.sensors.base_sensor import BaseSensor
from usdsdg.compat.isaacsim.sensors.camera import camera_axes as axes
from usdsdg.compat.isaacsim.sensors.camera.camera_axes import (  # noqa: F401 - scripts import them from here
    R_U_TRANSFORM,
    U_R_TRANSFORM,
    U_W_TRANSFORM,
    W_U_TRANSFORM,
)
from usdsdg.compat.isaacsim.sensors.camera.camera_images import CameraImages
from usdsdg.compat.wrappers.arrays import as_numpy
from usdsdg.create.render_products import render_product
from usdsdg.errors import ArgumentError
from usdsdg.listeners import weakly
from usdsdg.session.render_products import HydraTexture, product_at
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage, on_new_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras import default_view

RATE = "/app/runLoops/main/rateLimitFrequency"


class Camera(CameraImages, BaseSensor):
    """A camera prim, defined if there is none, and after `initialize` its images.

    Images show the stage at the latest update of the application, and are rendered when they are read; before the first
    update there are none. Poses are in the world's or parent's frame, quaternions (w, x, y, z), of a camera whose axes
    are "world" (+X ahead, +Z up), "ros" (+Z ahead, -Y up) or "usd" (-Z ahead, +Y up).
    """

    def __init__(
        self,
        prim_path: str,
        name: str = "camera",
        frequency: int | None = None,
        dt: float | None = None,
        resolution: tuple[int, int] | None = None,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        render_product_path: str | None = None,
        annotator_device: str | None = None,
    ) -> None:
        """Wrap or define the camera, and place it; `orientation` has "world" axes.

        Args:
            frequency: Frames of `get_current_frame` per second, a divisor of the rendering rate; or give `dt` [s].
            resolution: Width and height [pixels]; 128 x 128 by default.
            position: In the world; `translation` is relative to the parent.
            render_product_path: An existing render product to use, which gets this camera and resolution.
            annotator_device: Where annotators give arrays: "cpu", or "cuda" for Warp arrays.

        Raises:
            ArgumentError: both frequency and dt are given, or they do not divide the rendering rate; or there is a prim
                that is no camera.
        """
        self._resolution = (128, 128) if resolution is None else (int(resolution[0]), int(resolution[1]))
        self._set_rate(frequency, dt)
        stage = current_stage()
        existing = stage.GetPrimAtPath(prim_path)
        if existing and not existing.IsA(UsdGeom.Camera):
            raise ArgumentError(f"Camera: {prim_path} is a {existing.GetTypeName() or 'typeless prim'}, not a camera")
        if not existing:
            UsdGeom.Camera.Define(stage, prim_path)
            orientation = (1.0, 0.0, 0.0, 0.0) if orientation is None else orientation
        BaseSensor.__init__(self, prim_path, name, position=position, translation=translation)
        if orientation is not None and position is not None:
            self.set_world_pose(position, orientation)
        elif orientation is not None:
            self.set_local_pose(translation, orientation)
        self._square_pixels("vertical")
        self._render_product_path, self._annotator_device = render_product_path, annotator_device
        self._own_product: HydraTexture | None = None
        self._time_annotator: Annotator | None = None
        self._custom_annotators: dict[str, Annotator] = {}
        self._current_frame: dict[str, Any] = {"rendering_time": 0, "rendering_frame": 0}
        self._paused = True
        self._elapsed, self._previous_time = 0.0, None
        self._ends: list[Callable[[], None]] = []

    def __del__(self, python_ends: Callable[[], bool] = sys.is_finalizing) -> None:
        if vars(self).get("_ends") and not python_ends():  # nothing is left of the session then
            if self._own_product is not None:
                self._own_product.forget()
            self.destroy()

    # --- life ---
    def initialize(self, physics_sim_view: object = None, attach_rgb_annotator: bool = True) -> None:
        """Make the render product, and begin to take frames, unless that was done; after a world is reset.

        A world does it when it is reset, for a camera in its scene.

        Raises:
            BadPrim: the render product that was given does not exist.
        """
        BaseSensor.initialize(self, physics_sim_view)
        if self._ends:
            if attach_rgb_annotator and "rgb" not in self._custom_annotators:
                self.attach_annotator("rgb")
            return
        if self._render_product_path:
            product = product_at(self._render_product_path)
            product.set_resolution(self._resolution)
            product.set_camera(self.prim_path)
        else:
            name = self.prim_path.rsplit("/", 1)[-1]
            self._own_product = render_product(self.prim_path, self._resolution, force_new=True, name=name)
            # Its annotators are computed when they are read.
            self._own_product.captured_on_play = False
            self._render_product_path = self._own_product.path
        if attach_rgb_annotator:
            self.attach_annotator("rgb")
        self._time_annotator = named_annotators.get("ReferenceTime").attach(self._render_product_path)
        self._ends += [
            get_timeline().subscribe(weakly(self._follow_timeline)),
            get_app().subscribe_update(weakly(self._follow_update)),
            on_new_stage(weakly(self._leave_stage)),
        ]
        self.resume()

    def destroy(self) -> None:
        """Detach all annotators and remove the render product that `initialize` made, as a new stage does."""
        for name in list(self._custom_annotators):
            self.detach_annotator(name)
        if self._time_annotator is not None:
            self._time_annotator.detach()
        if self._own_product is not None:
            self._own_product.destroy()
        for end in self._ends:
            end()
        self._ends, self._time_annotator, self._own_product, self._render_product_path = [], None, None, None
        self._paused = True

    def post_reset(self) -> None:
        """Restore the default pose, and begin to count the time to the next frame anew."""
        BaseSensor.post_reset(self)
        self._elapsed, self._previous_time = 0.0, None

    def get_render_product_path(self) -> str | None:
        return self._render_product_path

    # --- rate and frames ---
    def set_frequency(self, value: int) -> None:
        """Set the frames of `get_current_frame` per second.

        Raises:
            ArgumentError: it does not divide the rendering rate.
        """
        rate = _rendering_rate()
        if value <= 0 or abs(rate / value - round(rate / value)) > 1e-6:
            raise ArgumentError(f"Camera: frequency {value} is no divisor of the rendering rate, {rate:g} per second")
        self._frequency = value

    def get_frequency(self) -> float:
        return self._frequency

    def set_dt(self, value: float) -> None:
        """Set the time between frames of `get_current_frame` [s].

        Raises:
            ArgumentError: it is no multiple of the rendering time step.
        """
        self.set_frequency(round(1.0 / value))

    def get_dt(self) -> float:
        return 1.0 / self._frequency

    def get_current_frame(self, clone: bool = False) -> dict[str, Any]:
        """Return the data of all annotators by name, with rendering_time [s] and rendering_frame (the reference time).

        Those of rgb are there as rgba too, as in Isaac Sim 4.
        With a `frequency` below the rendering rate it changes at that frequency only. clone: return a deep copy.
        """
        if self._frequency >= _rendering_rate():
            self._take_frame()
        return copy.deepcopy(self._current_frame) if clone else self._current_frame

    def pause(self) -> None:
        """Keep `get_current_frame` as it is."""
        self._take_frame()
        self._paused = True

    def resume(self) -> None:
        self._paused = False

    def is_paused(self) -> bool:
        return self._paused

    def _take_frame(self) -> None:
        if self._paused or self._time_annotator is None:
            return
        time = self._time_annotator.get_data()
        if not time or not time["referenceTimeDenominator"]:  # there was no update yet
            return
        seconds = time["referenceTimeNumerator"] / time["referenceTimeDenominator"]
        self._current_frame |= {"rendering_frame": time, "rendering_time": seconds, **self._data()}

    def _follow_update(self, dt: float) -> None:
        """Take a frame when one is due, at a frequency below the rendering rate."""
        if self._frequency >= _rendering_rate():
            return
        now = get_timeline().get_current_time()
        # A timeline that loops goes back.
        self._elapsed += 0.0 if self._previous_time is None else max(now - self._previous_time, 0.0)
        self._previous_time = now
        if self._elapsed >= self.get_dt() - 1e-9:
            self._elapsed = 0.0
            self._take_frame()

    def _leave_stage(self, stage: Usd.Stage) -> None:
        self.destroy()

    def _follow_timeline(self, event: str) -> None:
        if event == "stop":
            self.pause()
        elif event == "play":
            self.resume()

    def _set_rate(self, frequency: int | None, dt: float | None) -> None:
        if frequency is not None and dt is not None:
            raise ArgumentError("Camera: give either frequency or dt, not both")
        self._frequency: float = _rendering_rate()
        if dt is not None:
            self.set_dt(dt)
        elif frequency is not None:
            self.set_frequency(frequency)

    # --- resolution ---
    def get_resolution(self) -> tuple[int, int]:
        return self._resolution

    def set_resolution(self, value: tuple[int, int], maintain_square_pixels: bool = True) -> None:
        """Set width and height [pixels], and with square pixels the sensor's height."""
        self._resolution = int(value[0]), int(value[1])
        if self._render_product_path:
            product_at(self._render_product_path).set_resolution(self._resolution)
        if maintain_square_pixels:
            self._square_pixels("vertical")

    def get_aspect_ratio(self) -> float:
        width, height = self._resolution
        return width / height

    # --- poses ---
    def get_world_pose(self, camera_axes: str = "world") -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,) and orientation (4,) in the world.

        Raises:
            ArgumentError: there are no such axes.
        """
        position, orientation = BaseSensor.get_world_pose(self)
        return position, self._turned(orientation, camera_axes)

    def set_world_pose(
        self,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        camera_axes: str = "world",
    ) -> None:
        """Place the camera in the world; what is not given stays.

        Raises:
            ArgumentError: there are no such axes.
        """
        BaseSensor.set_world_pose(self, position, _usd_orientation(orientation, camera_axes))

    def get_local_pose(self, camera_axes: str = "world") -> tuple[np.ndarray, np.ndarray]:
        """Return translation (3,) and orientation (4,) relative to the parent.

        Raises:
            ArgumentError: there are no such axes.
        """
        translation, orientation = BaseSensor.get_local_pose(self)
        return translation, self._turned(orientation, camera_axes)

    def set_local_pose(
        self,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        camera_axes: str = "world",
    ) -> None:
        """Place the camera relative to its parent; what is not given stays.

        Raises:
            ArgumentError: there are no such axes.
        """
        BaseSensor.set_local_pose(self, translation, _usd_orientation(orientation, camera_axes))

    def _turned(self, orientation: Any, camera_axes: str) -> np.ndarray:
        return self._out(axes.from_usd(as_numpy(orientation), camera_axes)[0], None)


def get_all_camera_objects(root_prim: str = "/") -> list[Camera]:
    """Return a `Camera` for each camera prim below `root_prim`, named after the prim, or its path if names repeat."""
    paths = [path for path in default_view.cameras(current_stage()) if _is_below(path, root_prim)]
    names = [path.rsplit("/", 1)[-1] for path in paths]
    return [Camera(path, name=name if len(set(names)) == len(names) else path) for path, name in zip(paths, names)]


def _is_below(path: str, root: str) -> bool:
    return root == "/" or path == root or path.startswith(f"{root}/")


def _usd_orientation(orientation: Sequence[float] | None, camera_axes: str) -> Any:
    if orientation is None:
        axes.to_usd((1.0, 0.0, 0.0, 0.0), camera_axes)  # checks the name
        return None
    return axes.to_usd(as_numpy(orientation), camera_axes)[0]


def _rendering_rate() -> float:
    """Return the updates per second: the setting of the run loop, else the timeline's time codes per second."""
    rate = get_settings().get(RATE)
    return float(rate) if rate else float(get_timeline().get_time_codes_per_seconds())
