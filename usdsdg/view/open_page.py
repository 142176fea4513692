"""One page that is open: its camera, what it shows and what it has selected, drawn when it is out of date."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from usdsdg.errors import UsdsdgError, described
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.view import asking, drawing, pictures
from usdsdg.view.channel import Channel
from usdsdg.view.drawing import MODES, PATHS
from usdsdg.view.paths import ProgressivePaths, quick
from usdsdg.view.picking import Picked, pick
from usdsdg.view.scene import Camera, Scene

SIZE = (640, 480)
# The picture counts as moving for so long after the camera has moved [s], or the scene.
MOVING_SECONDS = 0.25
# Longest side of small pictures of cameras, and their interval while the scene moves [s].
SMALL, SMALL_SECONDS = 160, 0.5
SMALL_SAMPLES = 4


class OpenPage:
    """The state of one page. `ask` gets what concerns all pages: physics, triggers and frames."""

    def __init__(self, channel: Channel, scene: Scene, ask: Callable[[asking.Asking], None]) -> None:
        self.channel, self._scene, self._ask = channel, scene, ask
        self._orbit = scene.first_orbit()
        self._camera: Camera | None = None
        self._mode, self._size = PATHS, SIZE
        self._picked: Picked | None = None
        self._hit: dict[str, Any] = {}
        self._changes = 0  # of camera, mode, size and selection
        self._moved_at = self._small_at = -1e9
        self._drawn: Any = None  # key of the latest picture
        self._facts_of: Any = None  # what the page's facts are of
        self._paths = ProgressivePaths()
        self._small: dict[str, Any] = {}  # key of the small picture of each camera
        self._told: dict[str, Any] = {}
        self._error = ""

    # --- what the page asks for ---
    def hear(self) -> None:
        """Do what the page has asked for since the last call."""
        for text in self.channel.asked():
            try:
                self._do(asking.parse(text))
            except (asking.Misunderstood, UsdsdgError) as error:
                self.tell_error(error)

    def _do(self, wish: asking.Asking) -> None:
        match wish:
            case asking.Shown():
                self.channel.note_shown()
            case asking.Turn() | asking.Move() | asking.Zoom():
                self._steer(wish)
            case asking.Frame():
                self._frame(wish.what)
            case asking.Through():
                self._look_through(wish.camera)
            case asking.Mode():
                if wish.name not in (PATHS, *MODES):
                    raise asking.Misunderstood(f"no picture is called {wish.name!r}: {', '.join((PATHS, *MODES))}")
                self._mode = wish.name
                self._changed()
            case asking.Size():
                self._size = (wish.width, wish.height)
                self._changed()
            case asking.Pick():
                self._pick(wish.at)
            case _:
                self._ask(wish)

    def _steer(self, wish: asking.Turn | asking.Move | asking.Zoom) -> None:
        if self._camera is not None:  # from where the camera is, the page orbits freely
            self._look_through(None)
        if isinstance(wish, asking.Zoom):
            self._orbit = self._orbit.zoomed(wish.by)
        else:
            move = self._orbit.turned if isinstance(wish, asking.Turn) else self._orbit.moved
            self._orbit = move(*wish.by)
        self._moved_at = time.monotonic()
        self._changed()

    def _frame(self, what: str) -> None:
        self._camera = None
        if what == "all":
            self._orbit = self._scene.orbit_of_all()
        elif self._picked is not None and (middle := self._picked.middle(self._scene)) is not None:
            center, size = middle
            self._orbit = self._orbit.about(center, 2.5 * size or None)
        self._changed()

    def _look_through(self, path: str | None) -> None:
        if path is None:
            if self._camera is not None:
                self._orbit = self._scene.orbit_through(self._view())
            self._camera = None
        else:
            found = [camera for camera in self._scene.cameras() if camera.path == path]
            if not found:
                raise asking.Misunderstood(f"there is no camera {path}")
            self._camera = found[0]
        self._changed()

    def _pick(self, place: tuple[float, float] | None) -> None:
        picked = None if place is None else pick(self._scene, self._view(), place)
        self._picked, self._hit = picked or (None, {})
        self._changed()

    def _changed(self) -> None:
        self._changes += 1

    # --- what the page is told ---
    def tell(self, **values: Any) -> None:
        """Tell the page those values that differ from what it was told last."""
        new = {name: value for name, value in values.items() if self._told.get(name, ...) != value}
        if new:
            self._told |= new
            self.channel.tell(**new)

    def tell_error(self, error: Exception) -> None:
        """Tell the page what went wrong; once, until it is something else or has passed."""
        text = described(error) if isinstance(error, UsdsdgError) else str(error)
        if text != self._error:
            self._error = text
            self.channel.tell(error=text)

    # --- what it is shown ---
    def draw(self, *, is_moving: bool) -> bool:
        """Draw one picture, if one is out of date and the page is ready for it; return whether there was something.

        is_moving: whether the scene changes by itself, so that pictures have to be quick.
        """
        if not self.channel.wants_pictures:
            return False
        try:
            self._tell_facts()
            return self._draw_view(is_moving) or self._draw_small(is_moving)
        except UsdsdgError as error:
            self._drawn = self._key(quick=False)
            self.tell_error(error)
            return False

    @property
    def seconds_to_wait(self) -> float:
        """How long nothing is drawn, if nothing is asked [s]."""
        left = self._moved_at + MOVING_SECONDS - time.monotonic()
        return left if left > 0 else 60.0

    def _draw_view(self, is_moving: bool) -> bool:
        moved = time.monotonic() - self._moved_at < MOVING_SECONDS
        is_quick = self._mode == PATHS and (moved or is_moving or self._drawn is None)  # the first one is, too
        key = self._key(quick=is_quick)
        if key == self._drawn and (self._mode != PATHS or is_quick or self._paths.is_complete):
            return False
        begun = time.perf_counter()
        entries = self._picked.entries(self._scene) if self._picked is not None else frozenset()
        if self._mode == PATHS:
            view = self._view(2 if is_quick else 1)
            image = quick(self._scene, view) if is_quick else self._paths.improve(self._scene, view, key)
            drawn = drawing.Drawn(image, {"samples": 1 if is_quick else self._paths.samples})
            drawing.outline(self._scene, view, image, entries)
        else:
            view = self._view()
            drawn = drawing.draw(self._scene, view, self._mode, entries)
        header = {**drawn.about, "width": view.width, "height": view.height, "mode": self._mode}
        data = pictures.jpeg(drawn.image, sharp=self._mode not in (PATHS, "depth"))
        header["milliseconds"] = round(1000 * (time.perf_counter() - begun))
        self.channel.show("view", header, data)
        self._drawn, self._error = key, ""
        return True

    def _key(self, *, quick: bool) -> Any:
        return self._scene.version, self._changes, quick

    def _view(self, divisor: int = 1) -> CameraView:
        """Return the view of the page, at a fraction of its size."""
        width, height = self._size
        if self._camera is None:
            return self._orbit.view(width // divisor, height // divisor, self._scene.meters_per_unit)
        width, height = _fitted(self._camera, self._size)
        return self._scene.camera_view(self._camera.path, (max(width // divisor, 1), max(height // divisor, 1)))

    def _tell_facts(self) -> None:
        """Tell the page of the selected thing, where it may have changed."""
        through = None if self._camera is None else self._camera.path
        key = self._scene.version, self._picked, through
        if key != self._facts_of:
            self._facts_of = key
            facts = None if self._picked is None else self._picked.facts(self._scene) | self._hit
            self.tell(selection=facts, through=through)

    def _draw_small(self, is_moving: bool) -> bool:
        """Draw the small picture of one camera that is out of date."""
        now = time.monotonic()
        if now - self._moved_at < MOVING_SECONDS or (is_moving and now - self._small_at < SMALL_SECONDS):
            return False
        for camera in self._told.get("scene", {}).get("cameras", []):
            key = self._scene.version, self._mode
            if self._small.get(camera["path"]) == key:
                continue
            self._small[camera["path"]], self._small_at = key, now
            size = _fitted(Camera(camera["path"], tuple(camera["size"])), (SMALL, SMALL * 3 // 4))
            view = self._scene.camera_view(camera["path"], size)
            if self._mode == PATHS:
                image = quick(self._scene, view, SMALL_SAMPLES)
            else:
                image = drawing.draw(self._scene, view, self._mode).image
            self.channel.show(f"camera {camera['path']}", {"camera": camera["path"]}, pictures.jpeg(image))
            return True
        return False


def _fitted(camera: Camera, size: tuple[int, int]) -> tuple[int, int]:
    """Return the largest size with the shape of a camera's pictures that fits into another."""
    wide, high = camera.size if min(camera.size) > 0 else size
    scale = min(size[0] / wide, size[1] / high)
    return max(round(wide * scale), 1), max(round(high * scale), 1)
