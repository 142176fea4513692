"""The labels of one frame: AOVs from one ray through each pixel center, and masks of all labeled prims."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from usdsdg.annotators.labeled_prims import LabeledPrimReader, LabeledPrims
from usdsdg.capture.render_settings import glass_labels
from usdsdg.capture.requests import Requests
from usdsdg.capture.subsets import GprimTable, gprim_table
from usdsdg.capture.tiles import assembled, views_of
from usdsdg.session import engines
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView
from usdsdg.stage.geometry.pixel_masks import PixelMasks
from usdsdg_render.settings import LIGHT_AOVS


@dataclass(frozen=True)
class ProductLabels:
    """The labels of one render product."""

    table: GprimTable
    labeled_prims: LabeledPrims
    aovs: dict[str, Any]  # (H, W[, C]), NumPy arrays, or Warp arrays on a GPU
    amodal_masks: PixelMasks  # of all labeled prims; empty for products of several cameras


def render_labels(
    requests: Requests, views: Mapping[str, CameraView | TiledView], reader: LabeledPrimReader
) -> dict[str, ProductLabels]:
    """Render the labels of all products, by path; products with the same requirements are rendered in one batch."""
    renderer = engines.renderer()
    table = gprim_table(renderer.gprims, renderer.time)
    renderer.glass_labels = glass_labels()
    batches: dict[tuple[frozenset[str], bool, tuple[str | None, ...], bool], list[str]] = {}
    for path in views:
        needs = requests.requirements(path)
        key = (needs.aovs.difference(LIGHT_AOVS), needs.amodal_masks, needs.filters, needs.poses)
        batches.setdefault(key, []).append(path)
    labels = {}
    filters = {each for _, _, own, _ in batches for each in own}  # all, so that which product is first decides no row
    for (aovs, amodal_masks, _, poses), paths in batches.items():
        labeled_prims = reader.read(table.gprims, filters, time=renderer.time, poses=poses, places=renderer.places)
        cameras = [camera for path in paths for camera in views_of(views[path])]
        if amodal_masks:
            arrays, masks = renderer.labels_and_masks(
                cameras, aovs, labeled_prims.groups, faces=table.faces, fetched=False
            )
        else:
            arrays, masks = renderer.labels_of(cameras, aovs, faces=table.faces, fetched=False), []
        next_arrays, next_masks = iter(arrays), iter(masks)
        for path in paths:
            view = views[path]
            whole = assembled(view, [next(next_arrays) for _ in views_of(view)])
            empty = PixelMasks.nothing((view.height, view.width), len(labeled_prims))
            labels[path] = ProductLabels(table, labeled_prims, whole, next(next_masks, empty))
    return labels
