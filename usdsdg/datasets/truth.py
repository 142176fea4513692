"""What a record implies: ids, boxes, occlusion and points of one image."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from usdsdg.record import samples
from usdsdg.record.frame_record import FrameRecord, ProductRecord, SelectionRecord
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.pixels import pixel_centers
from usdsdg.writers.formats.shapes.visible_enough import ROUNDING

BACKGROUND, UNLABELLED, INVALID = "BACKGROUND", "UNLABELLED", "INVALID"


class Thing(NamedTuple):
    """A labeled prim in view."""

    path: str
    label: str  # as `text_of`
    labels: Mapping[str, str]
    id: int
    class_id: int
    visible: int  # pixels
    box: tuple[int, int, int, int] | None  # of the visible pixels: x_min, y_min, x_max, y_max, inclusive
    amodal: int | None  # pixels; None: not known
    amodal_box: tuple[int, int, int, int] | None
    bounds: np.ndarray  # (2, 3) in the prim's frame
    local_to_world: np.ndarray  # (4, 4)

    @property
    def occlusion(self) -> float | None:
        """The occluded fraction of its amodal pixels."""
        return None if not self.amodal else (self.amodal - self.visible) / self.amodal


class Truth:
    """One product's part of a frame record."""

    def __init__(self, record: FrameRecord, product: ProductRecord) -> None:
        self.record, self.product = record, product
        self.things = lru_cache(maxsize=None)(self._things)

    @property
    def camera(self) -> CameraView | None:
        """The camera; None where there are several in tiles."""
        return self.product.cameras[0] if len(self.product.cameras) == 1 else None

    def filter_of(self, annotator: str, default: str = "") -> str:
        """Return the label filter of an annotator of the writer, by its name."""
        return str(self._facts_of(annotator).get("filter") or default)

    def parameter(self, annotator: str, name: str) -> Any:
        """Return an init parameter of an annotator of the writer."""
        return self._facts_of(annotator).get("params", {}).get(name)

    def is_augmented(self, annotator: str) -> bool:
        """Return whether the user changed what an annotator of the writer gives, so that it is no AOV any more."""
        return bool(self._facts_of(annotator).get("augmentations"))

    def _facts_of(self, annotator: str) -> Mapping[str, Any]:
        """Return what is recorded of an annotator; files have its name without "_fast"."""
        known = self.record.annotators
        return known.get(annotator) or known.get(f"{annotator}_fast") or {}

    def selection(self, key: str) -> SelectionRecord | None:
        """Return the selection of a label filter; None if it is not recorded."""
        return self.product.selections.get(key)

    def members(self, key: str) -> np.ndarray | None:
        """Return the index into `things(key)` of each pixel, -1 for unlabeled and -2 for nothing."""
        gprims, selection = self.product.gprim_image, self.selection(key)
        if gprims is None or selection is None:
            return None
        return np.append(selection.member_of_gprim, -2)[gprims]

    def class_names(self, key: str) -> tuple[np.ndarray, list[str]] | None:
        """Return (H, W) indices into names, and those, of the labels of each pixel."""
        return self._named(key, [each.label for each in self.things(key)], BACKGROUND)

    def instance_names(self, key: str) -> tuple[np.ndarray, list[str]] | None:
        """As `class_names`, of the prim paths."""
        return self._named(key, [each.path for each in self.things(key)], BACKGROUND)

    def gprim_names(self) -> tuple[np.ndarray, list[str]] | None:
        """As `class_names`, of the gprims."""
        image = self.product.gprim_image
        return (
            None
            if image is None
            else (np.where(image < 0, len(self.product.gprims), image), [*self.product.gprims, INVALID])
        )

    def _named(self, key: str, names: list[str], nothing: str) -> tuple[np.ndarray, list[str]] | None:
        members = self.members(key)
        if members is None:
            return None
        return np.where(members < 0, len(names) - 1 - members, members), [*names, UNLABELLED, nothing]

    def is_visible_enough(self, thing: Thing) -> bool:
        """Return whether a thing is as visible as the writer's options `min_pixels` and `min_visibility` ask."""
        fewest, least = (
            self.record.parameters.get(f"min_{name}", own) for name, own in (("pixels", 1), ("visibility", 0))
        )
        return thing.visible >= max(fewest, 1) and (
            thing.occlusion is None or 1.0 - thing.occlusion >= least - ROUNDING
        )

    def keypoints(self, key: str) -> dict[str, dict[str, tuple[float, float, bool]]]:
        """Return column and row [pixels] of each keypoint, and whether it is in the picture, by thing and by name.

        A keypoint belongs to the nearest prim above it that the filter `key` selects. Of several of one name the last
        in the picture counts.
        """
        found: dict[str, dict[str, tuple[float, float, bool]]] = {}
        for owner, name, place in self.keypoints_in_turn(key):
            own = found.setdefault(owner, {})
            if place[2] or name not in own:
                own[name] = place
        return found

    def keypoints_in_turn(self, key: str) -> Iterator[tuple[str, str, tuple[float, float, bool]]]:
        """Yield all keypoints as `keypoints` has them; parts of a thing may have several of one name."""
        camera = self.camera
        if camera is None:
            return
        for each in self.product.keypoints:
            if key not in each.owners:
                continue
            pixels, depths = camera.project(each.positions)
            if camera.lens is not None and not camera.lens.is_flat:
                depths = np.linalg.norm(each.positions - camera.local_to_world[3, :3], axis=1)
            near, far = camera.clipping_range
            inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)
            inside &= (depths > near) & (depths < far)
            for name, (x, y), seen in zip(each.names, pixels.tolist(), inside.tolist()):
                yield each.owners[key], name, (x, y, seen)

    def _things(self, key: str) -> list[Thing]:
        members, selection = self.members(key), self.selection(key)
        if members is None or selection is None:
            return []
        product, count = self.product, len(selection.rows)
        visible = np.bincount(members[members >= 0], minlength=count)
        boxes = extents(members, count)
        found = []
        for index, row in enumerate(selection.rows.tolist()):
            amodal = None if product.amodal is None else int(product.amodal[row, 0])
            found.append(
                Thing(
                    product.prims[row],
                    text_of(selection.labels[index]),
                    selection.labels[index],
                    int(selection.ids[index]),
                    int(selection.class_ids[index]),
                    int(visible[index]),
                    tuple(boxes[index].tolist()) if visible[index] else None,
                    amodal,
                    tuple(product.amodal[row, 1:].tolist()) if product.amodal is not None and amodal else None,
                    product.bounds[row],
                    product.local_to_world[row],
                )
            )
        return found

    @cached_property
    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the pixels of which the depth is recorded."""
        return samples.grid_pixels(self.product.shape)

    @cached_property
    def plane_depth(self) -> np.ndarray | None:
        """Recorded distances along the optical axis [m]; None without depth or with several cameras."""
        if self.product.depth is None or self.camera is None:
            return None
        return plane_depth(self.camera, self.product.depth.astype(np.float64), *self.grid)

    @cached_property
    def grid_points(self) -> np.ndarray | None:
        """Points (h, w, 3) in the world [stage units] of the pixels of `grid`, NaN where nothing is hit."""
        if self.product.depth is None or self.camera is None:
            return None
        return points(self.camera, self.product.depth.astype(np.float64), *self.grid)


def rays(camera: CameraView, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return origins and directions, in the camera's frame, of the rays of pixels, in the shape of `rows` and 3."""
    origins, directions = camera.rays(pixel_centers(columns.ravel(), rows.ravel()))
    return np.reshape(origins, (*rows.shape, 3)), np.reshape(directions, (*rows.shape, 3))


def points(camera: CameraView, distance: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the points in the world at distances [m] along the rays of pixels; NaN where the distance is infinite."""
    origins, directions = rays(camera, rows, columns)
    along = np.where(np.isfinite(distance), distance, np.nan) / camera.meters_per_unit
    in_camera = origins + along[..., None] * directions
    return in_camera @ camera.local_to_world[:3, :3] + camera.local_to_world[3, :3]


def plane_depth(camera: CameraView, distance: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return distances along the optical axis [m] from those along the rays; infinite where those are."""
    _, directions = rays(camera, rows, columns)
    with np.errstate(invalid="ignore"):
        along = distance * -directions[..., 2]
    if camera.projection_type == "omniDirectionalStereo":
        origins, _ = rays(camera, rows, columns)
        along = along - origins[..., 2] * camera.meters_per_unit
    return np.where(np.isfinite(distance), along, np.inf)


def extents(members: np.ndarray, count: int) -> np.ndarray:
    """Return (count, 4) x_min, y_min, x_max, y_max, inclusive, of the pixels of each index; -1 for none."""
    rows, columns = np.nonzero(members >= 0)
    index = members[rows, columns]
    found = np.full((count, 4), -1, np.int64)
    low, high = np.full((count, 2), np.iinfo(np.int64).max), np.full((count, 2), -1)
    for axis, pixels in enumerate((columns, rows)):
        np.minimum.at(low[:, axis], index, pixels)
        np.maximum.at(high[:, axis], index, pixels)
    seen = high[:, 0] >= 0
    found[seen] = np.concatenate([low, high], axis=1)[seen]
    return found


def text_of(labels: Any) -> str:
    """Return labels {type: "label[,label]"} as one text, in an order that does not depend on that of the types."""
    if isinstance(labels, Mapping):
        if set(labels) == {"class"} and labels["class"] in (BACKGROUND, UNLABELLED):
            return str(labels["class"])
        return ";".join(f"{kind}:{label}" for kind, label in sorted(labels.items()))
    return str(labels)
