"""What a frame is in Rerun's terms: cameras, their pictures, depths, masks and boxes, objects, and draws.

All lengths are meters. A camera has USD's axes, x right, y up, z back, which Rerun calls RUB; pixels are counted from
the upper left corner of the picture, so that the first pixel has its center at (0.5, 0.5).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.colors import FIRST_LABELED, colors_of_ids
from usdsdg.errors import WriterError, warn_once
from usdsdg.writers.formats.class_names import shown_labels
from usdsdg.writers.formats.rerun.rerun_chunks import Logged, Moment
from usdsdg.writers.formats.rerun.rerun_extra import rerun
from usdsdg.writers.formats.shapes.camera_projection import camera_matrix, is_pinhole
from usdsdg.writers.formats.shards.encoding import image_bytes

WORLD, DRAWS = "/world", "/draws"
CAMERA, RGB, DEPTH, BOXES_2D, BOXES_3D = (
    "camera_params", "rgb", "distance_to_image_plane", "bounding_box_2d_tight", "bounding_box_3d_360",
)  # fmt: skip
MASKS = ("instance_segmentation", "semantic_segmentation")
_MOST_IDS = 1 << 16  # Rerun's class ids have 16 bits
_MEDIA = {"png": "image/png", "jpeg": "image/jpeg"}

Seen = Mapping[str, Any]  # of one render product, by annotator name


def entities(
    products: Mapping[str, Seen], draws: Mapping[str, Any], moment: Moment, *, up: str, image_format: str
) -> Iterator[Logged]:
    """Yield what is logged of a frame; what shows at the same place as an earlier one comes after it.

    products: the payload of each render product. draws: values of the named distributions. up: axis of the stage.
    """
    rr = rerun()
    axes = rr.ViewCoordinates.RIGHT_HAND_Y_UP if up == "Y" else rr.ViewCoordinates.RIGHT_HAND_Z_UP
    yield Logged(WORLD, axes, None)
    for name, seen in products.items():
        for path, archetype in (*_camera(seen), *_images(seen, image_format), *_masks(seen), *_rectangles(seen)):
            yield Logged("/".join(filter(None, (WORLD, name, path))), archetype, moment)
    first = next((seen for seen in products.values() if BOXES_3D in seen), None)
    if first is not None:
        # All objects of the stage are in each frame, whichever camera sees them; those that are gone leave.
        yield Logged(f"{WORLD}/objects", rr.Clear(recursive=True), moment)
        for path, archetype in _objects(first):
            yield Logged(f"{WORLD}/objects{path}", archetype, moment)
    for name, values in draws.items():
        if isinstance(values, np.ndarray) and values.dtype.kind in "biuf":
            yield Logged(f"{DRAWS}/{name}", rr.Scalars(values.astype(np.float64).ravel()), moment)


def _camera(seen: Seen) -> Iterator[tuple[str, Any]]:
    rr, params = rerun(), seen[CAMERA]
    to_world = np.linalg.inv(np.asarray(params["cameraViewTransform"], np.float64).reshape(4, 4))
    meters = float(params["metersPerSceneUnit"])
    # USD's matrices are for row vectors, Rerun's for columns.
    yield "", rr.Transform3D(translation=to_world[3, :3] * meters, mat3x3=to_world[:3, :3].T)
    if not is_pinhole(params):
        warn_once(
            f"RerunWriter: {seen['camera']} has the projection {params['cameraModel']!r}; Rerun has pinholes only, so "
            "its pictures are not placed in the world"
        )
        return
    matrix = camera_matrix(params)
    matrix[:2, 2] += 0.5  # from centers of pixels to the corner
    width, height = (int(size) for size in params["renderProductResolution"])
    yield "", rr.Pinhole(image_from_camera=matrix, resolution=[width, height], camera_xyz=rr.ViewCoordinates.RUB)


def _images(seen: Seen, image_format: str) -> Iterator[tuple[str, Any]]:
    rr = rerun()
    if RGB in seen:
        pixels = np.asarray(seen[RGB]["data"])[..., :3]
        contents = image_bytes(pixels, image_format)
        yield RGB, rr.EncodedImage(contents=contents, media_type=_MEDIA[image_format])
    if DEPTH in seen:
        yield DEPTH, rr.DepthImage(np.asarray(seen[DEPTH]["data"], np.float32), meter=1.0)


def _masks(seen: Seen) -> Iterator[tuple[str, Any]]:
    rr = rerun()
    for name in MASKS:
        if name not in seen:
            continue
        ids, labels = np.asarray(seen[name]["data"]), seen[name]["idToLabels"]
        if ids.max(initial=0) >= _MOST_IDS:
            raise WriterError(f"RerunWriter: {name} has the id {ids.max()}; Rerun's ids end at {_MOST_IDS - 1}.")
        known = {int(key): shown_labels(value) for key, value in labels.items()}
        colors = colors_of_ids(list(known)).tolist()
        context = [(key, text, tuple(color)) for (key, text), color in zip(known.items(), colors)]
        yield name, rr.AnnotationContext(context)
        yield name, rr.SegmentationImage(ids.astype(np.uint16))


def _rectangles(seen: Seen) -> Iterator[tuple[str, Any]]:
    if BOXES_2D not in seen:
        return
    rows = seen[BOXES_2D]["data"]
    low = np.stack([rows["x_min"], rows["y_min"]], axis=1).astype(np.float32)
    # Bounds are inclusive pixels.
    high = np.stack([rows["x_max"], rows["y_max"]], axis=1).astype(np.float32) + 1
    yield BOXES_2D, rerun().Boxes2D(mins=low, sizes=high - low, **_named(seen[BOXES_2D]))


def _objects(seen: Seen) -> Iterator[tuple[str, Any]]:
    """Yield the pose of each object, and its box in its own frame, by prim path."""
    rr, found, meters = rerun(), seen[BOXES_3D], float(seen[CAMERA]["metersPerSceneUnit"])
    named, poses = _named(found), _poses(found, meters)
    for index, (row, path) in enumerate(zip(found["data"], found["primPaths"], strict=True)):
        pose = _below(path, poses)
        yield path, rr.Transform3D(translation=pose[3, :3], mat3x3=pose[:3, :3].T)
        low, high = (np.array([row[f"{axis}_{end}"] for axis in "xyz"], np.float64) for end in ("min", "max"))
        own = {name: values[index : index + 1] for name, values in named.items()}
        yield path, rr.Boxes3D(centers=[(low + high) / 2], half_sizes=[(high - low) / 2], **own)


def _poses(found: Mapping[str, Any], meters: float) -> dict[str, np.ndarray]:
    """Return the matrix (4, 4) of each object to the world [m], row vectors, by prim path."""
    to_meters = np.diag((meters, meters, meters, 1.0))
    matrices = np.asarray(found["data"]["transform"], np.float64).reshape(-1, 4, 4)
    return dict(zip(found["primPaths"], matrices @ to_meters))


def _below(path: str, poses: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the matrix of an object to the object that its path is below, of which Rerun makes the one to the world.

    What is in an object without volume, as one of scale 0, has no such matrix: the nearest one is returned.
    """
    above = path.rpartition("/")[0]
    while above and above not in poses:
        above = above.rpartition("/")[0]
    return poses[path] @ np.linalg.pinv(poses[above]) if above else poses[path]


def _named(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return the labels of rows of boxes, and the colors of their instances."""
    labels = {int(key): shown_labels(value) for key, value in found["idToLabels"].items()}
    return {
        "labels": [labels.get(int(row["semanticId"]), "") for row in found["data"]],
        "colors": colors_of_ids(np.asarray(found.get("bboxIds", np.arange(len(found["data"])) + FIRST_LABELED))),
    }
