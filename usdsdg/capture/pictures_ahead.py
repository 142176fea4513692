"""Color images of the next frames, traced together as worlds, for captures that look at these frames one by one."""

from __future__ import annotations

from typing import Any

import numpy as np

from usdsdg.capture.render_settings import RenderMode, path_settings, tone_settings
from usdsdg.capture.requests import Requests
from usdsdg.capture.time_dependence import check_time_independent
from usdsdg.errors import Unsupported, warn_once
from usdsdg.graph.evaluate import graph
from usdsdg.graph.worlds import WorldDraws
from usdsdg.session import engines
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.settings import LIGHT_AOVS


class PicturesAhead:
    """The frames from `frame` on, `count` of them, which are drawn together and shown one after the other.

    Making one authors the first of them.

    Raises:
        Unsupported: they cannot be drawn together; the graph has not run then.
    """

    def __init__(self, frame: int, count: int) -> None:
        check_time_independent()
        self._draws = WorldDraws(graph(), frame, count)
        self.frame = frame
        self._pictures: dict[str, dict[str, Any]] = {}
        try:
            self._values: WorldValues | None = self._draws.values()
            self.count = count
        except Unsupported as error:
            warn_once(f"{error} Frames are rendered one by one.")
            self._values, self.count = None, 1

    def trace(self, requests: Requests, mode: RenderMode) -> None:
        """Trace the color images of all frames for the products that need them."""
        if self._values is None or self.count == 1 or mode.motion_blur:
            return
        renderer, needs = engines.renderer(), requests.requirements
        products = [
            each
            for each in requests.products()
            if each.tiles is None and needs(each.path).path_tracing and needs(each.path).aovs.isdisjoint(LIGHT_AOVS)
        ]
        if not products:
            return
        now = stage_time(current_stage())
        settings = path_settings(mode, self.frame, with_light_aovs=False)
        try:
            renderer.place_worlds(self._values, now)
            for product in products:
                view = read_camera(current_stage(), product.camera_path, product.resolution, time=renderer.time)
                self._pictures[product.path] = renderer.world_pictures(
                    view, samples=mode.samples, settings=settings, tone=tone_settings(mode)
                )
        except Unsupported as error:
            warn_once(f"{error} Color images are traced one by one.")
            self._pictures = {}

    def show(self, frame: int) -> None:
        """Author what a frame shows; the first one is shown from the start."""
        if self._values is not None and frame > self.frame:
            self._draws.author(self._values, current_stage(), frame - self.frame)

    def pictures(self, frame: int) -> dict[str, dict[str, Any]]:
        """Return the color images of a frame by the path of the product, of those that have been traced."""
        world = frame - self.frame
        return {
            path: {name: _image(array, world) for name, array in images.items()}
            for path, images in self._pictures.items()
        }


def _image(images: Any, world: int) -> Any:
    return np.array(images.numpy()[world]) if images.device.is_cpu else images[world]
