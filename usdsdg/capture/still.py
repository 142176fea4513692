"""A picture of the stage as it is, with labels, beside the run: no frame is counted and nothing of the run takes part.

It is rendered from a twin of the stage by a renderer of its own, with ids of its own, and is seeded by the number of
the next frame. What remembers earlier frames (motion, the class table of the dataset, the journal) does not see it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.delivery import delivered
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.annotators.requirements import requirements
from usdsdg.capture.exposure import SAMPLES_PER_CALL
from usdsdg.capture.frame_scene import EarlierPoints, FrameScene
from usdsdg.capture.render_settings import RenderMode, glass_labels, path_settings, still_mode, tone_settings
from usdsdg.capture.subsets import gprim_table
from usdsdg.session import engines
from usdsdg.session.progress import report
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras import default_view
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.geometry.pixel_masks import PixelMasks
from usdsdg.stage.twin import twin_of

PATH = "/Preview"  # what the frame has for a render product


@dataclass(frozen=True)
class Still:
    """A picture of the stage with its labels. Arrays are NumPy's."""

    view: CameraView
    annotations: dict[str, Annotation]  # by annotator name
    has_light: bool  # False: it was drawn with a plain sky and a sun


def still(
    camera: str | None, resolution: tuple[int, int], annotators: Sequence[Annotator], *, samples: int | None = None
) -> Still:
    """Draw the current stage through the camera at a path, or through one that frames all of it.

    samples: path-traced, per pixel; None: those of the fast mode, whatever the settings say.

    Raises:
        StageError: there is no camera and no visible geometry.
        BadPrim: there is no such camera.
        RenderError: the camera gives no image of this size.
    """
    stage, number = twin_of(current_stage()), current().orchestrator.captures
    time = stage_time(current_stage())
    has_light = default_view.has_light(stage)
    if not has_light:
        default_view.add_sky(stage)
    path = camera or default_view.add_camera(stage, resolution[0] / resolution[1], time)
    renderer = engines.new_renderer(stage)
    renderer.glass_labels = glass_labels()
    renderer.sync(time)
    view = read_camera(stage, path, resolution, time=renderer.time)
    needs, table = requirements(annotators), gprim_table(renderer.gprims, renderer.time)
    reader = LabeledPrimReader(stage, for_dataset=False)
    labeled_prims = reader.read(table.gprims, needs.filters, time=renderer.time)
    if needs.amodal_masks:
        (aovs,), (masks,) = renderer.labels_and_masks([view], needs.aovs, labeled_prims.groups, faces=table.faces)
    else:
        (aovs,) = renderer.labels_of([view], needs.aovs, faces=table.faces)
        masks = PixelMasks.nothing((view.height, view.width), len(labeled_prims))
    images = _images(renderer, view, still_mode(samples), number) if needs.path_tracing else {}
    frame = Frame(
        index=number, view=view, render_product=PATH, gprims=table.gprims, aovs=aovs | images,
        labeled_prims=labeled_prims, amodal_masks=masks,
        scene=FrameScene(PATH, view, table, aovs, EarlierPoints(), renderer),
    )  # fmt: skip
    found = {each.get_name(): delivered(each.compute(frame), None, copy=False) for each in annotators}
    reader.close()
    return Still(view, found, has_light)


def _images(renderer: engines.Renderer, view: CameraView, mode: RenderMode, number: int) -> dict:
    """Return the color images of a view."""
    film = renderer.new_film(view.width, view.height)
    for part in mode.split(-(-mode.samples // SAMPLES_PER_CALL)):
        settings = path_settings(part, number, with_light_aovs=False)
        renderer.accumulate_all([film], [view], samples=part.samples, settings=settings)
        if mode.path_tracing:
            report("preview: samples per pixel", part.first_sample + part.samples, mode.samples)
    return renderer.develop(film, tone_settings(mode))
