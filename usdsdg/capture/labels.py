"""The labels of one frame: AOVs from one ray through each pixel center, and masks of all labeled prims."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.capture.render_settings import glass_labels
from usdsdg.capture.requests import Requests
from usdsdg.capture.subsets import SETTING, GprimTable, gprim_table
from usdsdg.capture.tiles import assembled, views_of
from usdsdg.errors import Unsupported
from usdsdg.session import engines
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.stage.geometry.pixel_masks import PixelMasks
from usdsdg_render.settings import LIGHT_AOVS

FACE = "prim"  # the AOV of faces


@dataclass(frozen=True)
class ProductLabels:
    """The labels of one render product."""

    table: GprimTable
    labeled_prims: LabeledPrims
    aovs: dict[str, np.ndarray]
    amodal_masks: PixelMasks  # of all labeled prims; empty for products of several cameras


def render_labels(
    requests: Requests, views: Mapping[str, CameraView | TiledView], reader: LabeledPrimReader
) -> dict[str, ProductLabels]:
    """Render the labels of all products, by path; products with the same requirements are rendered in one batch.

    Raises:
        Unsupported: an annotator that needs whole masks, such as boxes, while GeomSubsets are told apart.
    """
    renderer = engines.renderer()
    table = gprim_table(renderer.gprims, renderer.time)
    renderer.glass_labels = glass_labels()
    batches: dict[tuple[frozenset[str], bool, tuple[str | None, ...]], list[str]] = {}
    for path in views:
        needs = requests.requirements(path)
        batches.setdefault((needs.aovs.difference(LIGHT_AOVS), needs.amodal_masks, needs.filters), []).append(path)
    labels = {}
    for (aovs, amodal_masks, filters), paths in batches.items():
        labeled_prims = reader.read(table.gprims, filters, time=renderer.time)
        cameras = [camera for path in paths for camera in views_of(views[path])]
        divided = bool(table.parts) and "instance" in aovs
        if divided:
            aovs |= {FACE}
        if amodal_masks:
            _check_whole(table, paths)
            arrays, masks = renderer.labels_and_masks(cameras, aovs, labeled_prims.groups)
        else:
            arrays, masks = renderer.labels_of(cameras, aovs), []
        next_arrays, next_masks = iter(arrays), iter(masks)
        for path in paths:
            view = views[path]
            whole = assembled(view, [next(next_arrays) for _ in views_of(view)])
            if divided:
                whole["instance"] = table.entries(whole["instance"], whole[FACE])
            empty = PixelMasks.nothing((view.height, view.width), len(labeled_prims))
            labels[path] = ProductLabels(table, labeled_prims, whole, next(next_masks, empty))
    return labels


def _check_whole(table: GprimTable, paths: Sequence[str]) -> None:
    if table.parts:
        raise Unsupported(
            f"{', '.join(paths)}: boxes, occlusion and visibility cannot be computed while {SETTING} is on; masks of "
            "GeomSubsets can. Turn it off, or capture boxes in a run of their own."
        )
