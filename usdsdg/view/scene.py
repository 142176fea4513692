"""The current stage as the pages look at it: read when it has changed, with its labels, bounds and cameras."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.capture.render_settings import glass_labels
from usdsdg.capture.subsets import GprimTable, gprim_table
from usdsdg.errors import AssetError, RenderError, StageError, Unsupported
from usdsdg.session import engines
from usdsdg.session.render_products import products
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras import default_view
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.poses.transforms import meters_per_unit
from usdsdg.view.orbit import Orbit

ASPECT = 4 / 3
NO_LIGHT = "The stage has no light: a plain sky and a sun are added for the viewer."
NOTHING = "The stage has no visible geometry."


@dataclass(frozen=True)
class Camera:
    """A camera of the stage; `size` is the resolution of the first render product that shows it, (0, 0) without one."""

    path: str
    size: tuple[int, int]


class Scene:
    """The current stage, whichever that is.

    `version` grows with each change: what was drawn of an earlier one is out of date.
    """

    def __init__(self) -> None:
        self.version = 0
        self.notes: list[str] = []
        self._stage: Usd.Stage | None = None
        self._is_read = False
        self._reader: LabeledPrimReader | None = None
        self._table = GprimTable(())
        self._labeled: LabeledPrims | None = None

    def change(self) -> None:
        """Note that the stage or the time may have changed."""
        self.version += 1
        self._is_read, self._labeled = False, None

    def read(self) -> engines.Renderer:
        """Bring the renderer up to date, and return it.

        Raises:
            UsdsdgError: as the renderer raises.
        """
        if self._stage != current_stage():
            self._begin(current_stage())
        renderer = engines.renderer()
        if not self._is_read:
            renderer.sync(stage_time(self.stage))
            renderer.glass_labels = glass_labels()
            self._table = gprim_table(renderer.gprims, renderer.time)
            self._is_read = True
        return renderer

    @property
    def stage(self) -> Usd.Stage:
        """The stage that was read last."""
        return current_stage() if self._stage is None else self._stage

    @property
    def table(self) -> GprimTable:
        """The gprims of the pixels of the AOV `instance`."""
        self.read()
        return self._table

    @property
    def labeled(self) -> LabeledPrims:
        """The labeled prims."""
        if self._labeled is None:
            renderer = self.read()
            assert self._reader is not None
            self._labeled = self._reader.read(self._table.gprims, (None,), time=renderer.time)
        return self._labeled

    def cameras(self) -> list[Camera]:
        """Return the cameras of the stage, those of render products first."""
        sizes: dict[str, tuple[int, int]] = {}
        for product in products():
            if product.tiles is None:
                sizes.setdefault(product.camera_path, product.resolution)
            else:
                sizes |= {path: product.tiles.size for path in product.tiles.cameras if path not in sizes}
        found = default_view.cameras(self.stage)
        with_products = [path for path in sizes if path in found]
        return [Camera(path, sizes.get(path, (0, 0))) for path in dict.fromkeys([*with_products, *found])]

    def camera_view(self, path: str, size: tuple[int, int]) -> CameraView:
        """Return the camera at `path` for pictures of a size, at the current time.

        Raises:
            BadPrim: it is no camera.
            RenderError: its attributes give no image.
        """
        return read_camera(self.stage, path, size, time=self.read().time)

    def orbit_of_all(self) -> Orbit:
        """Return the orbit that sees all of the stage from a three-quarter view.

        Raises:
            StageError: there is no visible geometry.
        """
        low, high = default_view.world_bounds(self.stage, self.read().time)
        to_world, distance, _ = default_view.looking_at_all(self.stage, ASPECT, self.read().time)
        target = to_world[3, :3] - distance * to_world[2, :3]
        axes = default_view.axes(self.stage)
        return Orbit.looking(to_world[3, :3], target, axes, size=float(np.linalg.norm(high - low)))

    def orbit_through(self, view: CameraView) -> Orbit:
        """Return the orbit that sees what a camera sees, about what is in the middle of its picture."""
        everything = self.orbit_of_all()
        eye, back = view.local_to_world[3, :3], view.local_to_world[2, :3]
        hit = self.first_hit(view, (view.width / 2, view.height / 2))
        distance = (
            hit[0] if hit is not None and hit[0] > 0.0 else float(np.linalg.norm(np.asarray(everything.target) - eye))
        )
        return Orbit.looking(eye, eye - distance * back, everything.axes, size=everything.size)

    def first_orbit(self) -> Orbit:
        """Return the orbit at which a page opens: through the first camera that gives an image, else of all."""
        try:
            self.orbit_of_all()
        except StageError:
            self.note(NOTHING)
            return Orbit.looking(
                np.ones(3), np.zeros(3), default_view.axes(self.stage), size=1.0 / self.meters_per_unit
            )
        for camera in self.cameras():
            try:
                return self.orbit_through(self.camera_view(camera.path, (160, 120)))
            except (RenderError, AssetError, Unsupported) as error:
                self.note(str(error))
        return self.orbit_of_all()

    def note(self, text: str) -> None:
        """Add something that pages say about the stage, once."""
        if text not in self.notes:
            self.notes.append(text)

    def first_hit(self, view: CameraView, pixel: tuple[float, float]) -> tuple[float, int, np.ndarray] | None:
        """Return what a pixel of a view shows: distance [stage units], entry of the table, point (3,); None: nothing.

        pixel: column and row from the top left corner, as real numbers.
        """
        origins, directions = view.rays(np.array([pixel]))
        if not np.isfinite(directions).all():
            return None
        rotation, place = view.local_to_world[:3, :3], view.local_to_world[3, :3]
        behind = max(-view.clipping_range[0], 0.0)  # where the rays of an orthographic camera may start
        origins, directions = origins @ rotation + place + behind * rotation[2], directions @ rotation
        limits = [np.array([limit], np.float32) for limit in (0.0, np.inf)]
        distances, entries = self.read().first_hits(origins, directions, *limits, faces=self.table.faces)
        if entries[0] < 0:
            return None
        distance = float(distances[0])
        return distance - behind, int(entries[0]), origins[0] + distance * directions[0]

    @property
    def meters_per_unit(self) -> float:
        """Meters per unit of the stage."""
        return meters_per_unit(self.stage)

    def _begin(self, stage: Usd.Stage) -> None:
        if self._reader is not None:
            self._reader.close()
        self._stage, self._reader, self._labeled = stage, LabeledPrimReader(stage), None
        self._is_read, self.version, self.notes = False, self.version + 1, []
        if not default_view.has_light(stage):
            default_view.add_sky(stage)
            self.note(NO_LIGHT)
