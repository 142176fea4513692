"""One captured frame: which products are drawn, with what, and who is told.

Films are exposed once per sub-frame; labels come from one centre-ray pass over the state at the last exposure.
"""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np
from pxr import Usd

from usdsdg.annotators.annotator import Annotator, attached_annotators, requirements
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.annotators.payload import build_payload
from usdsdg.capture.graph_outputs import distribution_outputs, trigger_outputs
from usdsdg.capture.render_settings import RenderMode, glass_labels
from usdsdg.capture.tiles import joined, view_of, views_of
from usdsdg.create.render_products import HydraTexture, products
from usdsdg.errors import Unsupported, warn_once
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session import engines
from usdsdg.session.progress import report, say
from usdsdg.session.session import current
from usdsdg.session.settings_store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.geometry.pixel_masks import Outlines
from usdsdg.writers import base as writer_base
from usdsdg.writers.base import Writer, attached_writers
from usdsdg_render.settings import LIGHT_AOVS, PathSettings, ToneSettings

# Ticks per second of reference times.
TICKS = 1_000_000
# Positions of things within one motion-blur sub-frame: enough that fast ones leave a streak, not a row of copies.
BLUR_STEPS = 4
SAMPLES_PER_CALL = 16
# How often the queue of files is looked at while waiting for its end.
DRAIN_SECONDS = 0.02


class _Seen(NamedTuple):
    """What one product shows, besides its picture."""

    labeled_prims: LabeledPrims
    labels: list[dict[str, np.ndarray]]  # per camera
    amodal_masks: Outlines  # of all labeled prims; products of many cameras have none


class Capture:
    """Draws the enabled render products of one frame and hands them to annotators and writers."""

    def __init__(self) -> None:
        self._labeled_prims: LabeledPrimReader | None = None
        self._wanted: dict[str, list[Annotator]] = {}
        self._due: list[Writer] = []
        self._films: dict[str, list[Any]] = {}  # of each product, one per tile
        self._mode: RenderMode | None = None
        self._announced: set[tuple[str, str]] = set()
        self.expected_frames: int | None = None  # for progress, where somebody knows

    @staticmethod
    def is_watched() -> bool:
        """Whether an annotator or writer is attached to a render product that has its updates on."""
        on = {product.path for product in products() if product.updates_enabled}
        seen = [annotator.render_product for annotator in attached_annotators()]
        seen += [path for writer in attached_writers() for path in writer.render_products]
        return not on.isdisjoint(seen)

    def begin(self) -> None:
        """Find out who wants what of which product."""
        self._wanted = {}
        self._films = {}
        writer_base.set_global_seed(get_global_seed())
        for annotator in attached_annotators():
            self._want(annotator.render_product, [annotator], f"annotator {annotator.get_name()!r}")
        # Asked once: a writer's own trigger function may have a memory.
        self._due = [writer for writer in attached_writers() if writer.is_due()]
        for writer in self._due:
            for path in writer.render_products:
                self._want(path, writer.annotators_of(path), type(writer).__name__)

    def _want(self, path: str | None, annotators: list[Annotator], who: str) -> None:
        product = next((product for product in products() if product.path == path), None)
        if product is None:
            warn_once(
                f"{who} is attached to {path}, which has been destroyed, and gets nothing of it. Detach it, or attach "
                "it to another render product."
            )
        elif product.updates_enabled:
            _check_tiles(product, annotators, who)
            self._wanted.setdefault(product.path, []).extend(annotators)

    def open_shutter(self) -> None:
        """Note where things are when a blurred exposure begins."""
        if self._wanted:
            engines.renderer().sync(_now())

    def expose(self, mode: RenderMode, frame: int) -> None:
        """Add samples to the film of every product whose picture is wanted.

        With motion blur they are spread over the way that things made since the last exposure or `open_shutter`.
        """
        if not self._wanted:
            return
        self._mode = mode
        engines.renderer().sync(_now())
        if not mode.motion_blur:
            # In several calls only so that progress can be told; the picture is the same bit for bit.
            for share in mode.split(-(-mode.samples // SAMPLES_PER_CALL)):
                self._add_samples(share, frame, mode.samples)
            return
        shares = mode.split(BLUR_STEPS)
        for step, share in enumerate(shares):
            engines.renderer().place_between((step + 0.5) / len(shares))
            self._add_samples(share, frame, mode.samples * mode.sub_frames)
        engines.renderer().place_between(1.0)

    def _add_samples(self, mode: RenderMode, frame: int, total: int) -> None:
        renderer = engines.renderer()
        alike: dict[bool, list[tuple[Any, CameraView]]] = {}  # films and their views, by whether light AOVs are wanted
        for product in self._active():
            needs = requirements(self._wanted[product.path])
            if not needs.path_tracing:
                continue
            views = views_of(view_of(product, renderer.time))
            if product.path not in self._films:
                self._films[product.path] = [renderer.new_film(view.width, view.height) for view in views]
            exposed = alike.setdefault(not needs.aovs.isdisjoint(LIGHT_AOVS), [])
            exposed += zip(self._films[product.path], views, strict=True)
        for with_light_aovs, exposed in alike.items():
            films, views = zip(*exposed, strict=True)
            settings = _path_settings(mode, frame, with_light_aovs=with_light_aovs)
            renderer.accumulate_all(films, views, samples=mode.samples, settings=settings)
        if mode.path_tracing:
            report(f"frame {frame}: samples per pixel", min(mode.first_sample + mode.samples, total), total)

    def finish(self, index: int, seconds: float) -> None:
        """Make the labels, then let annotators compute and writers write."""
        if not self._wanted:
            return
        renderer = engines.renderer()
        renderer.glass_labels = glass_labels()
        views = {product.path: view_of(product, renderer.time) for product in self._active()}
        seen = self._seen(views)
        frames = {path: self._frame(path, view, seen[path], index, seconds) for path, view in views.items()}
        for annotator in attached_annotators():
            if annotator.render_product in frames:
                annotator.compute(frames[annotator.render_product])
        for writer in self._due:
            self._write(writer, frames)
        report("frames captured", index + 1, self.expected_frames)

    def _active(self) -> list[HydraTexture]:
        return [product for product in products() if product.path in self._wanted]

    def _seen(self, views: dict[str, Any]) -> dict[str, _Seen]:
        """What labels want to know of each product; products that want the same are drawn together."""
        renderer = engines.renderer()
        paths_by_needs: dict[tuple[frozenset[str], bool, tuple[str | None, ...]], list[str]] = {}
        for path in views:
            needs = requirements(self._wanted[path])
            key = needs.aovs.difference(LIGHT_AOVS), needs.amodal_masks, needs.filters
            paths_by_needs.setdefault(key, []).append(path)
        seen = {}
        for (aovs, amodal_masks, filters), paths in paths_by_needs.items():
            labeled_prims = self._read_labeled_prims(renderer.gprims, filters)
            cameras = [views_of(views[path]) for path in paths]
            flat = [each for some in cameras for each in some]
            if amodal_masks:
                labels, outlines = renderer.outlined(flat, aovs, labeled_prims.groups)
            else:
                labels, outlines = renderer.labels_of(flat, aovs), []
            drawn, around = iter(labels), iter(outlines)
            for path, some in zip(paths, cameras, strict=True):
                mine = [next(drawn) for _ in some]
                nothing = Outlines.nothing((views[path].height, views[path].width), len(labeled_prims))
                seen[path] = _Seen(labeled_prims, mine, next(around, nothing))
        return seen

    def _frame(self, path: str, view: Any, seen: _Seen, index: int, seconds: float) -> Frame:
        """What annotators see of the product at `path`."""
        renderer = engines.renderer()
        aovs = joined(view, seen.labels)
        if path in self._films:
            assert self._mode is not None
            tone = _tone_settings(self._mode)
            aovs |= joined(view, [renderer.develop(film, tone) for film in self._films.pop(path)])
        return Frame(
            index=index, camera=view, render_product=path, aovs=aovs, gprims=renderer.gprims,
            labeled_prims=seen.labeled_prims, amodal_masks=seen.amodal_masks,
            reference_time=(round(seconds * TICKS), TICKS),
        )  # fmt: skip

    def _read_labeled_prims(self, gprims: tuple[str, ...], filters: tuple[str | None, ...]) -> LabeledPrims:
        if self._labeled_prims is None:
            self._labeled_prims = LabeledPrimReader(current_stage())
        return self._labeled_prims.read(gprims, filters, time=engines.renderer().time)

    def _write(self, writer: Writer, frames: dict[str, Frame]) -> None:
        seen = {path: frames[path] for path in writer.render_products if path in frames}
        if seen:
            self._announce(writer)
            outputs = {"trigger_outputs": trigger_outputs(), "distribution_outputs": distribution_outputs()}
            writer.receive(build_payload(writer, seen, **outputs))

    def _announce(self, writer: Writer) -> None:
        """Say once where the files of a writer go."""
        folder = getattr(writer.backend, "output_dir", None)
        place = (type(writer).__name__, folder)
        if folder is not None and place not in self._announced:
            self._announced.add(place)
            say(f"{place[0]} writes to {folder}")

    def drain(self) -> None:
        """Wait until every file is on disk; raises the first failure."""
        first = waiting = current().io_queue.open_jobs()
        while waiting:
            report("files written", first - waiting, first)
            time.sleep(DRAIN_SECONDS)
            waiting = current().io_queue.open_jobs()
        if first:
            report("files written", first, first)
        current().io_queue.wait_until_done()

    def close_writers(self) -> None:
        """Tell every writer that the last frame has been written."""
        for writer in attached_writers():
            writer.on_final_frame()
        current().io_queue.wait_until_done()


def _check_tiles(product: HydraTexture, annotators: list[Annotator], who: str) -> None:
    needing = [annotator.get_name() for annotator in annotators if annotator.needs_amodal_masks]
    if product.tiles is not None and needing:
        raise Unsupported(
            f"{who}: {', '.join(needing)} cannot be told of {product.path}, which shows {len(product.tiles.cameras)} "
            "cameras in tiles. Attach to a render product of each camera (create.render_product)."
        )


def _now() -> Usd.TimeCode:
    """The timeline's time as a time code of the stage."""
    return Usd.TimeCode(get_timeline().get_current_time() * current_stage().GetTimeCodesPerSecond())


def _path_settings(mode: RenderMode, frame: int, *, with_light_aovs: bool) -> PathSettings:
    settings = get_settings()
    keys = {"seed": get_global_seed(), "frame": frame, "first_sample": mode.first_sample, "light_aovs": with_light_aovs}
    keys["glass_bounces"] = settings.get_as_int("/rtx/pathtracing/maxSpecularAndTransmissionBounces")
    if not mode.path_tracing:
        return PathSettings.fast(**keys)
    return PathSettings(bounces=settings.get_as_int("/rtx/pathtracing/maxBounces"), denoise=mode.denoise, **keys)


def _tone_settings(mode: RenderMode) -> ToneSettings:
    settings = get_settings()
    return ToneSettings(
        film_iso=settings.get_as_float("/rtx/post/tonemap/filmIso"),
        shutter=settings.get_as_float("/rtx/post/tonemap/cameraShutter"),
        f_number=settings.get_as_float("/rtx/post/tonemap/fNumber"),
        denoise=mode.denoise,
        denoiser=mode.denoiser,
        denoiser_blend=mode.denoiser_blend,
    )
