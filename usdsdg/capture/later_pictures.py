"""Color images that get their pixels while the next frame is evaluated and simulated, where only files will show them.

On CPUs another thread traces them. On a GPU their kernels are launched after the annotators' data have been copied to
the host, because launches and copies of one stream run in order; a copy to page-locked memory follows them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.annotator import Annotator
from usdsdg.capture.exposure import Exposure
from usdsdg.capture.render_settings import RenderMode
from usdsdg.capture.requests import Requests
from usdsdg.parallel import Later, available_threads
from usdsdg.readback import Arrival, Landing, device_of
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.base import Writer

SETTING = "/usdsdg/capture/picturesLater"
COLOR = "LdrColor"
# What a backend must not do in ways of its own, so that the files of a frame are jobs of the queue.
_SCHEDULING = {"schedule", "schedule_together", "schedule_in_turn", "schedule_after_all", "_submit", "write_image"}


def may_be_later(requests: Requests, mode: RenderMode) -> bool:
    """Return whether nothing reads the pixels of a frame's color images before the jobs that encode them.

    On a CPU with one thread there is nothing to work beside.
    """
    return (
        get_settings().get_as_bool(SETTING)
        and not mode.motion_blur
        and current().observations.light_seen  # else the capture searches the image for light, to warn of black images
        and _go_to_files(requests)
        and (engines.renderer().device != "cpu" or available_threads() > 1)
    )


def _go_to_files(requests: Requests) -> bool:
    """Return whether there are color images, all of which are for writers that only store them."""
    stored: set[int] = set()
    for writer in requests.writers:
        if _only_stores(writer):
            stored.update(map(id, writer.annotators))
    traced = [
        each for annotators in requests.annotators.values() for each in annotators if each.spec.needs_path_tracing
    ]
    return bool(traced) and all(id(each) in stored and _is_image(each) for each in traced)


def _only_stores(writer: Writer) -> bool:
    """Return whether a writer's own `write` hands color images unseen to a backend that stores them later."""
    owner = next(each for each in type(writer).__mro__ if "write" in vars(each))
    if not vars(owner).get("only_stores_pictures") or "write" in vars(writer) or writer.backend is None:
        return False
    return _runs_jobs(writer.backend)


def _runs_jobs(backend: BaseBackend) -> bool:
    """Return whether all that a backend schedules becomes jobs of the queue, as those of usdsdg do."""
    own = all(getattr(type(backend), name).__module__.startswith("usdsdg.") for name in _SCHEDULING)
    return own and not vars(backend).keys() & _SCHEDULING and all(map(_runs_jobs, getattr(backend, "backends", ())))


def _is_image(annotator: Annotator) -> bool:
    """Return whether it passes the color image on as it is, to the host."""
    return annotator.is_color_image and annotator.device in (None, "cpu")


def later_pictures(
    exposure: Exposure, mode: RenderMode, views: Mapping[str, CameraView | TiledView]
) -> LaterPictures | CopiedPictures:
    """Return the color images of one frame's products; the capture begins them when annotators have been computed.

    views: by path, of all products of the frame, as the latest `sync` of the renderer shows them.
    """
    return (LaterPictures if engines.renderer().device == "cpu" else CopiedPictures)(exposure, mode, views)


class CopiedPictures:
    """The color images of one frame's products, by path. They have no pixels until `tracing` was waited for."""

    def __init__(self, exposure: Exposure, mode: RenderMode, views: Mapping[str, CameraView | TiledView]) -> None:
        self._exposure, self._views = exposure, views
        self._device = device_of(engines.renderer().device)
        self._steps = exposure.steps(mode)
        self._landings = {
            path: Landing((views[path].height, views[path].width, 4), np.uint8, page_locked=self._device.is_cuda)
            for path in exposure.exposed
        }
        self.images = {path: {COLOR: landing.copy} for path, landing in self._landings.items()}
        self.tracing = Arrival({path: landing.copy for path, landing in self._landings.items()}, None)

    def begin(self) -> None:
        """Launch the kernels that trace the images, and the copies to the host."""
        for step in self._steps:
            step.run()
        for path, landing in self._landings.items():
            landing.receive(self._exposure.images(path, self._views[path])[COLOR])
        self.tracing.begin(self._device)


class LaterPictures:
    """The color images of one frame's products, by path. They have no pixels until `tracing` has ended.

    The thread that traces them starts when this is made, beside the annotators.
    """

    def __init__(self, exposure: Exposure, mode: RenderMode, views: Mapping[str, CameraView | TiledView]) -> None:
        self._exposure = exposure
        self._views = views
        self._steps = exposure.steps(mode)
        self.images: dict[str, dict[str, np.ndarray[Any, Any]]] = {
            path: {COLOR: np.empty((views[path].height, views[path].width, 4), np.uint8)} for path in exposure.exposed
        }
        self.tracing: Later = engines.renderer().later(self._trace)

    def begin(self) -> None:
        """Do nothing: the thread has started."""

    def _trace(self) -> None:
        for step in self._steps:
            step.run()
        for path, images in self.images.items():
            images[COLOR][...] = self._exposure.images(path, self._views[path])[COLOR]
