"""Many worlds in memory: at each step what all worlds show, in arrays on the device, in place of writers."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from pxr import Usd

from usdsdg.annotators.colors import BACKGROUND, UNLABELLED
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.annotators.selection import Selection
from usdsdg.capture.render_settings import RenderMode, glass_labels, path_settings, tone_settings
from usdsdg.capture.time_dependence import check_time_independent
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import WorldDraws
from usdsdg.session import engines
from usdsdg.session.progress import report_frames
from usdsdg.session.render_products import HydraTexture, products
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline, stage_time
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.world_values import WorldValues
from usdsdg.writers.base import attached_writers

if TYPE_CHECKING:
    import warp as wp

_PICTURES = {"rgb": "LdrColor", "LdrColor": "LdrColor", "HdrColor": "HdrColor"}
_IDS = ("semantic_segmentation", "instance_segmentation")
BOXES = "bounding_box_2d_tight"
_REMEDY = "Run without worlds."
# Held while a step reads or writes the stage: a trainer may save a world meanwhile.
_stage_lock = threading.Lock()


@dataclass(frozen=True)
class WorldBatch:
    """What one render product shows in all worlds of one step.

    Attributes:
        frame: index of the frame that world 0 is; world w is frame `frame` + w of a run of single frames.
        render_product: name of the render product.
        camera: prim path of its camera.
        arrays: by annotator, (worlds, height, width, ...) Warp arrays on the device that rendered them:
            rgb, LdrColor: vec4ub; HdrColor: vec4h [nits]; semantic_segmentation, instance_segmentation: int32 ids as
            those annotators give, without colors; every AOV of the renderer in its type.
            bounding_box_2d_tight: (worlds, prims, 5) int32: visible pixels, x_min, y_min, x_max, y_max [pixels,
            inclusive], -1 for prims that are not in view.
        prims: paths of the labeled prims, the rows of bounding_box_2d_tight.
        class_ids: (prims,) int64, ids in `classes` of the labels of each.
        classes: the class table of the dataset, labels by id.
        values: what differs between the worlds; `values.author(stage, w)` writes world w to a stage.
        ready: a CUDA event after which the arrays are there; None on a CPU.
    """

    frame: int
    render_product: str
    camera: str
    arrays: Mapping[str, Any]
    prims: tuple[str, ...]
    class_ids: np.ndarray
    classes: Mapping[int, Mapping[str, str]]
    values: WorldValues
    ready: Any

    def wait(self) -> None:
        """Wait until the arrays are there."""
        if self.ready is not None:
            import warp as wp

            wp.synchronize_event(self.ready)

    def save_world(self, world: int, path: str) -> None:
        """Write the stage as one world shows it to a file, flattened: the graph's draws of that world.

        What the script itself has changed after this step is in it, too.

        Raises:
            ArgumentError: there is no such world.
        """
        if not 0 <= world < self.values.count:
            raise ArgumentError(f"world {world!r} is none of 0 to {self.values.count - 1}")
        with _stage_lock:
            flat = Usd.Stage.Open(current_stage().Flatten())
        self.values.author(flat, world)
        flat.GetRootLayer().Export(path)


Receive = Callable[[WorldBatch], None]


class WorldTap:
    """Draws and renders `count` worlds at each step of the orchestrator, and hands over a batch for each product."""

    def __init__(self, count: int, annotators: Sequence[str], receive: Receive) -> None:
        """
        Raises:
            ArgumentError: `count` is below 1, or worlds cannot show an annotator.
        """
        whole = int(count) if isinstance(count, SupportsIndex) else 0
        if whole < 1:
            raise ArgumentError(f"worlds: {count!r} is no number of worlds; expected 1 or more")
        known = (*_PICTURES, *_IDS, BOXES, *(name for name in engines.renderer_aovs() if name != "motion_vectors"))
        if unknown := [name for name in annotators if name not in known]:
            raise ArgumentError(
                f"worlds cannot show {', '.join(map(str, unknown))}; they can show {', '.join(known)}. {_REMEDY}"
            )
        self.count, self._annotators, self._receive = whole, tuple(annotators), receive
        self._reader: LabeledPrimReader | None = None
        self._stage: Usd.Stage | None = None
        self._checked: Usd.Stage | None = None  # whose frames do not follow from each other
        self._drawn: WorldValues | None = None  # the last, of which that stage shows world 0
        self._nodes: list[Node] = []  # that have drawn them

    def draw(self, frame: int) -> WorldValues:
        """Run the graph for the worlds that begin with `frame`.

        Raises:
            Unsupported: the timeline plays, captured frames follow from each other (see `check_time_independent`), or
                as `WorldDraws`.
        """
        if get_timeline().is_playing():
            raise Unsupported(f"worlds: the timeline plays, and worlds have no physics and no time. {_REMEDY}")
        if self._checked is not current_stage():
            check_time_independent(_REMEDY)
            self._checked, self._drawn = current_stage(), None
        with _stage_lock:
            nodes = [node for trigger in graph().triggers for node in trigger.nodes]
            if self._drawn is not None:
                self._drawn.author_last(current_stage(), steady=nodes != self._nodes)
            self._nodes = nodes
            draws = WorldDraws(graph(), frame, self.count)
            values = self._drawn = draws.values()
            draws.count_triggers()
        return values

    def capture(self, values: WorldValues, frame: int, mode: RenderMode) -> None:
        """Render the worlds, and hand them over.

        Raises:
            Unsupported: motion blur is on, or a product has several cameras in tiles; as `place_worlds`.
        """
        if mode.motion_blur:
            raise Unsupported(f"worlds: motion blur exposes over time, which worlds do not have. {_REMEDY}")
        renderer = engines.renderer()
        now = stage_time(current_stage())
        with _stage_lock:
            renderer.look_at_files()
            renderer.place_worlds(values, now)
            renderer.glass_labels = glass_labels()
            batches = [self._batch(product, values, frame, mode) for product in _products()]
        for batch in batches:
            self._receive(batch)
        report_frames(frame + self.count, None)

    def _batch(self, product: HydraTexture, values: WorldValues, frame: int, mode: RenderMode) -> WorldBatch:
        renderer, wanted = engines.renderer(), self._annotators
        view = read_camera(current_stage(), product.camera_path, product.resolution, time=renderer.time)
        arrays: dict[str, Any] = {}
        aovs = {name for name in wanted if name in engines.renderer_aovs()}
        prims, selection = self._labeled()
        if labeled := [name for name in wanted if name in (*_IDS, BOXES)]:
            aovs.add("instance")
        if aovs:
            batch = renderer.world_labels(view, aovs)
            arrays |= {name: batch.arrays[name] for name in wanted if name in aovs}
            for name in labeled:
                arrays[name] = _labels(name, batch, selection)
        if pictures := [name for name in wanted if name in _PICTURES]:
            settings = path_settings(mode, frame, with_light_aovs=False)
            shown = renderer.world_pictures(view, samples=mode.samples, settings=settings, tone=tone_settings(mode))
            arrays |= {name: shown[_PICTURES[name]] for name in pictures}
        return WorldBatch(
            frame,
            product.path.rsplit("/", 1)[-1],
            view.prim_path,
            {name: arrays[name] for name in wanted},
            prims,
            selection.class_ids,
            selection.class_labels,
            values,
            _event(renderer.device),
        )

    def _labeled(self) -> tuple[tuple[str, ...], Selection]:
        """Return the paths of all labeled prims, and their rows, numbers and classes."""
        stage, renderer = current_stage(), engines.renderer()
        if self._reader is None or self._stage is not stage:
            self._reader, self._stage = LabeledPrimReader(stage), stage
        return self._reader.names_and_selection(renderer.gprims, current().label_filter, time=renderer.time)


def _products() -> list[HydraTexture]:
    """Return the products that writers are attached to; all of them where there is no writer.

    Raises:
        Unsupported: one has several cameras.
    """
    written = {path for writer in attached_writers() for path in writer.render_products}
    shown = [each for each in products() if each.updates_enabled and (each.path in written or not attached_writers())]
    for product in shown:
        if product.tiles is not None:
            raise Unsupported(f"worlds: {product.path} has several cameras in tiles; use a product for each. {_REMEDY}")
    return shown


def _labels(name: str, batch: Any, selection: Selection) -> wp.array:
    """Return ids of pixels, or boxes of the labeled prims, from the AOV `instance` of all worlds."""
    members = selection.member_of_gprim
    if name == BOXES:
        from usdsdg_render.labels.label_batch import boxes_of

        return boxes_of(batch.masks(members, -1), len(selection), threads=batch.threads)
    ids = selection.class_ids if name == "semantic_segmentation" else selection.ids
    return batch.masks(np.append(ids, UNLABELLED)[members], BACKGROUND)


def _event(device: str) -> Any:
    if device == "cpu":
        return None
    import warp as wp

    return wp.get_stream(device).record_event()
