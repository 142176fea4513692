"""YCB-Video: labels, boxes and poses of the visible objects, and model points that poses take to their pixels."""

from __future__ import annotations

from collections import Counter

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.ycb_video import NAME, Meta
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.record import samples
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.poses.rotations import matrix_from_euler
from usdsdg.verify.checks.compare import differs, is_rotation, of_pixels, text
from usdsdg.verify.checks.poses import is_straight

_TIGHT, _CLASSES, _NODE, _BOXES = "bounding_box_2d_tight", "semantic_segmentation", "pose", "bounding_box_3d"
_OPENCV = (180.0, 0.0, 0.0)
_FLOAT32 = 4e-6
_PIXEL = 0.05
_GRAY = 3.0  # levels by which a picture of the inverse depth may be off the straight line through it


def check(seen: Seen) -> Faults:
    """Check the files of an image."""
    if seen.format != NAME:
        return
    meta: Meta | None = seen.extra.get("meta")
    file, label = seen.extra.get("label", ("", None))
    indices = _indices(seen)
    if seen.truth is not None and indices is not None:
        if label is not None:
            yield from _labels(seen, file, label, indices, seen.truth)
        yield from _boxes(seen, indices, seen.truth)
        if meta is not None and seen.truth.camera is not None:
            yield from _poses(seen, meta, indices, seen.truth, seen.truth.camera)
    if "inverse depth" in seen.extra and seen.truth is not None:
        gray_file, gray = seen.extra["inverse depth"]
        yield from _inverse_depth(seen, gray_file, gray, seen.truth)
    if meta is not None:
        yield from _agrees(seen, meta, file, label)
    for name, lines in seen.lines:
        yield from _rectangles(seen, name, lines)


def _indices(seen: Seen) -> dict[str, int] | None:
    """Return the index of each class, in lower case; None where it is not recorded."""
    if seen.truth is None:
        return None
    given = seen.truth.record.parameters.get("class_name_to_index_map") or {}
    return {str(name).lower(): int(index) for name, index in given.items()}


def _class(thing: Thing, indices: dict[str, int]) -> str:
    whole = thing.labels.get("class") or ",".join(thing.labels.values())
    return whole if whole in indices else whole.split(",")[0]


def _labels(seen: Seen, file: str, label: np.ndarray, indices: dict[str, int], truth: Truth) -> Faults:
    """Every pixel has the index of the class that was there."""
    key = truth.filter_of(_CLASSES)
    members, things = truth.members(key), truth.things(key)
    if members is None:
        return
    if label.shape != members.shape:
        yield Fault(file, seen.name, "has another size", str(members.shape), str(label.shape))
        return
    own = [indices.get(_class(each, indices), 0) for each in things]
    expected = np.array([*own, 0, 0])[np.where(members < 0, len(own), members)]
    if (label != expected).any():
        yield Fault(file, seen.name, f"the index of the class differs in {of_pixels(label != expected)}")


def _boxes(seen: Seen, indices: dict[str, int], truth: Truth) -> Faults:
    """The lines are the boxes of what is visible."""
    for file, lines in seen.lines:
        things = [each for each in truth.things(truth.filter_of(_TIGHT)) if each.visible]
        names = ("_".join(_class(each, indices).split()) for each in things)
        expected = Counter(f"{name} {' '.join(map(str, each.box or ()))}" for name, each in zip(names, things))
        found = Counter(" ".join(fields) for fields in lines)
        for line in expected - found:
            yield Fault(file, seen.name, f"the box `{line}` is missing")
        for line in found - expected:
            yield Fault(file, seen.name, f"the box `{line}` is of nothing that is visible")


def _rectangles(seen: Seen, file: str, lines: list[list[str]]) -> Faults:
    for name, *corners in lines:
        left, top, right, bottom = (int(each) for each in corners)
        inside = seen.size is None or (right < seen.size[0] and bottom < seen.size[1])
        if not (0 <= left <= right and 0 <= top <= bottom and inside):
            yield Fault(file, seen.name, f"the box of {name} is in the image", "", " ".join(corners))


def _inverse_depth(seen: Seen, file: str, image: np.ndarray, truth: Truth) -> Faults:
    """Gray levels are those of the inverse of the depth, scaled by whatever is nearest and farthest."""
    depth = truth.plane_depth
    if depth is None or image.shape != truth.product.shape:
        return
    inverse = np.where(np.isfinite(depth), 1.0 / np.maximum(depth * 100.0, 1e-9), 1e-5).ravel()
    levels = samples.grid(image).astype(np.float64).ravel()
    if np.ptp(inverse) <= 0:
        return
    slope, offset = np.polyfit(inverse, levels, 1)
    off = np.abs(levels - (slope * inverse + offset))
    if slope < 0 or off.max() > _GRAY:
        where = f"{int((off > _GRAY).sum())} of {off.size} places"
        yield Fault(file, seen.name, f"the gray level is not the inverse of the depth in {where}")


def _poses(seen: Seen, meta: Meta, indices: dict[str, int], truth: Truth, camera: CameraView) -> Faults:
    """The objects are the visible ones of known classes, each with its pose and center."""
    key = truth.filter_of(_BOXES if meta.exact else _NODE)
    left = [each for each in truth.things(key) if each.visible and _class(each, indices) in indices]
    matrix = truth.record.parameters.get("intrinsic_matrix")
    own = np.array([[camera.fx, 0, camera.cx - 0.5], [0, camera.fy, camera.cy - 0.5], [0, 0, 1]])
    if meta.exact and differs(meta.matrix, own, relative=1e-7):
        yield Fault(meta.file, seen.name, "intrinsic_matrix", text(own), text(meta.matrix))
    elif not meta.exact and isinstance(matrix, list) and differs(meta.matrix, matrix, relative=1e-9):
        yield Fault(meta.file, seen.name, "intrinsic_matrix", text(matrix), text(meta.matrix))
    if meta.exact:
        yield from _from_world(seen, meta, camera)
    factor = int(truth.record.parameters.get("factor_depth") or 10000)
    if meta.factor != factor:
        yield Fault(meta.file, seen.name, "factor_depth", str(factor), str(meta.factor))
    for index, pose, center in zip(meta.indices.tolist(), meta.poses, meta.centers):
        same = [each for each in left if indices[_class(each, indices)] == index]
        if not same:
            yield Fault(meta.file, seen.name, f"an object of class {index} is not visible, or listed too often")
            continue
        thing = min(same, key=lambda each: float(np.abs(_pose(meta, truth, camera, each)[:, 3] - pose[:, 3]).max()))
        left.remove(thing)
        yield from _object(seen, meta, pose, center, thing, truth, camera)
    for thing in left:
        yield Fault(meta.file, seen.name, f"{thing.path} is visible and has no pose")


def _from_world(seen: Seen, meta: Meta, camera: CameraView) -> Faults:
    """The camera of the file is the recorded one, from the world in meters."""
    axes = matrix_from_euler(_OPENCV)
    turned = (camera.world_to_camera[:3, :3] @ axes).T
    moved = camera.world_to_camera[3, :3] @ axes * camera.meters_per_unit
    expected = np.column_stack([turned, moved])
    if meta.to_camera is None:
        yield Fault(meta.file, seen.name, "rotation_translation_matrix is missing")
    elif differs(meta.to_camera, expected, relative=1e-6, absolute=1e-9):
        name = "rotation_translation_matrix"
        yield Fault(meta.file, seen.name, name, text(expected), text(meta.to_camera))


def _object(
    seen: Seen, meta: Meta, pose: np.ndarray, center: np.ndarray, thing: Thing, truth: Truth, camera: CameraView
) -> Faults:
    expected = _pose(meta, truth, camera, thing)
    if differs(pose[:, 3], expected[:, 3], relative=_FLOAT32, absolute=1e-6):
        yield Fault(meta.file, seen.name, f"position of {thing.path}", text(expected[:, 3]), text(pose[:, 3]))
    linear = thing.local_to_world
    is_rigid = is_straight(linear) and np.linalg.det(linear[:3, :3]) > 0
    if (is_rigid or not meta.exact) and differs(pose[:, :3], expected[:, :3], relative=0.0, absolute=1e-4):
        yield Fault(meta.file, seen.name, f"axes of {thing.path}", text(expected[:, :3]), text(pose[:, :3]))
    (pixel,), (depth,) = camera.project(linear[3:, :3])
    if camera.projection_type != "pinhole" or depth <= camera.clipping_range[0]:
        return
    if meta.exact:
        pixel = pixel - 0.5
    elif not _is_opencv(truth) or truth.parameter(_NODE, "imageWidth") not in (0, None, camera.width):
        return
    if differs(center, pixel, relative=_FLOAT32, absolute=_PIXEL):
        yield Fault(meta.file, seen.name, f"center of {thing.path}", text(pixel), text(center))


def _is_opencv(truth: Truth) -> bool:
    return tuple(truth.parameter(_NODE, "cameraRotation") or _OPENCV) == _OPENCV


def _pose(meta: Meta, truth: Truth, camera: CameraView, thing: Thing) -> np.ndarray:
    """Return what the file must have of an object, (3, 4); of a sheared one in an exact file only the position."""
    axes = thing.local_to_world[:3, :3]
    axes = axes / np.linalg.norm(axes, axis=1 if meta.exact else 0, keepdims=True)
    turn = matrix_from_euler(_OPENCV if meta.exact else truth.parameter(_NODE, "cameraRotation") or _OPENCV)
    rows = np.vstack([axes, thing.local_to_world[3, :3]]) @ camera.world_to_camera[:3, :3]
    rows[3] += camera.world_to_camera[3, :3]
    found = (rows @ turn).T
    found[:, 3] *= camera.meters_per_unit if meta.exact else 1.0
    return found


def _agrees(seen: Seen, meta: Meta, file: str, label: np.ndarray | None) -> Faults:
    """Whatever is recorded: labels and poses are of the same classes, and points on the models are at their pixels."""
    if not len(meta.indices) == len(meta.poses) == len(meta.centers):
        found = f"{len(meta.indices)}, {len(meta.poses)}, {len(meta.centers)}"
        yield Fault(meta.file, seen.name, "cls_indexes, poses and center differ in number", "", found)
        return
    if label is not None and file.endswith(".png"):
        drawn = set(np.unique(label).tolist()) - {0}
        if drawn != set(meta.indices.tolist()):
            listed = ", ".join(map(str, sorted(set(meta.indices.tolist()))))
            shown = ", ".join(map(str, sorted(drawn)))
            yield Fault(file, seen.name, f"shows other classes than {meta.file} has poses of", listed, shown)
    if not meta.exact:
        return
    for index, pose in enumerate(meta.poses):
        if not is_rotation(pose[:, :3], absolute=1e-5):
            yield Fault(meta.file, seen.name, f"pose {index} has no rotation", "", text(pose[:, :3]))
    projected = (meta.poses[:, :, 3] @ meta.matrix.T)[meta.poses[:, 2, 3] > 0]
    if differs(meta.centers[meta.poses[:, 2, 3] > 0], projected[:, :2] / projected[:, 2:], relative=1e-6):
        yield Fault(meta.file, seen.name, "center is where poses and intrinsics take the origin", text(projected))
    if label is not None:
        yield from _points(seen, meta, label)


def _points(seen: Seen, meta: Meta, label: np.ndarray) -> Faults:
    """`vertmap` is, by the pose of an object of the pixel's class, on the ray of the pixel and at its depth."""
    assert meta.points is not None
    if meta.points.shape[:2] != label.shape:
        yield Fault(meta.file, seen.name, "vertmap has another size", str(label.shape), str(meta.points.shape[:2]))
        return
    depth = seen.depths[0].values if seen.depths else None
    for index in np.unique(meta.indices).tolist():
        rows, columns = np.nonzero(label == index)
        least = np.full(len(rows), np.inf)
        for pose in meta.poses[meta.indices == index]:
            points = meta.points[rows, columns].astype(np.float64) @ pose[:, :3].T + pose[:, 3]
            pixels = points @ meta.matrix.T
            with np.errstate(divide="ignore", invalid="ignore"):
                off = np.abs(pixels[:, :2] / pixels[:, 2:] - np.stack([columns, rows], axis=1)).max(axis=1)
            if depth is not None:
                known = np.isfinite(depth[rows, columns])
                there = np.abs(points[:, 2] - np.where(known, depth[rows, columns], points[:, 2]))
                off = np.maximum(off, np.where(there > 1.0 / meta.factor + 1e-5 * points[:, 2], np.inf, 0.0))
            least = np.fmin(least, np.where(points[:, 2] > 0, off, np.inf))
        if (least > _PIXEL).any():
            count = int((least > _PIXEL).sum())
            yield Fault(
                meta.file, seen.name, f"poses take vertmap to the pixels of class {index}", f"all {len(rows)}",
                f"{len(rows) - count}",
            )  # fmt: skip
