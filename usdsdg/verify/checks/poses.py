"""Poses: of the right objects, in every frame in which they are written, and projected onto the object's pixels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.pose import expected
from usdsdg.datasets.seen import Posed, Poses, Seen
from usdsdg.datasets.truth import Thing
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import beyond, differs, pairs, text

_ORDER = ("Center", *(x + y + z for x in "LR" for y in "DU" for z in "BF"))
_DOPE_FIRST = "LUF"
_FLOAT32 = 2e-6
_STRAIGHT = 1e-5  # by which products of axes that are perpendicular may be off, as those of quaternions of 16 bits are
_SIZES = ("size", "scale")
_PIXEL = 0.51  # keypoints are rounded to whole pixels
_REACH = 2.0  # pixels by which an object may reach over its projected box
_OF_POINTS = ("projected_cuboid", "cuboid_keypoints_projected")  # the keypoints in pixels, by format
_KEYS: Mapping[str, tuple[str, ...]] = {  # what every object of a format has
    "default": (
        "local_to_world_transform", "location_world_frame", "rotation_matrix_world_frame", "quat_wxyz_world_frame",
        "location_camera_frame", "rotation_matrix_camera_frame", "quat_wxyz_camera_frame", "size",
        "cuboid_keypoints_world_frame", "cuboid_keypoints_camera_frame", "cuboid_keypoints_projected",
        "truncation_ratio",
    ),
    "dope": ("location", "quaternion_xyzw", "projected_cuboid", "truncation_ratio"),
    "centerpose": (
        "location", "quaternion_xyzw", "scale", "keypoints_3d", "projected_cuboid", "truncation_ratio",
    ),
}  # fmt: skip


def check(seen: Seen) -> Faults:
    """Compare pose files with the record, and their frames with each other."""
    for poses in seen.poses:
        if sorted(poses.order) != sorted(_ORDER) or poses.order[0] not in ("Center", _DOPE_FIRST):
            yield Fault(poses.file, seen.name, "keypoint_order", ", ".join(_ORDER), ", ".join(poses.order))
            continue
        for each in poses.objects:
            yield from _agrees(seen, poses, each)
        if seen.truth is not None and seen.truth.camera is not None:
            things = expected(seen.truth, poses.threshold)
            matched, faults = pairs(
                seen, poses.file, [each.path for each in poses.objects], [each.path for each in things], "the pose of"
            )
            yield from faults
            for mine, theirs in matched:
                yield from _object(seen, poses, poses.objects[mine], things[theirs], seen.truth.camera)


def _object(seen: Seen, poses: Poses, posed: Posed, thing: Thing, camera: CameraView) -> Faults:
    label = thing.labels.get("class", "")
    if posed.label != label:
        yield Fault(poses.file, seen.name, f"the label of {thing.path}", label, posed.label)
    visible = 1.0 - (thing.occlusion or 0.0)
    if differs(posed.visibility, visible, relative=0.0, absolute=6e-4):
        yield Fault(poses.file, seen.name, f"visibility of {thing.path}", f"{visible:.3f}", f"{posed.visibility:g}")
    for name, value in _values(poses, thing, camera).items():
        accuracy = 2 * _STRAIGHT if name in _SIZES else _FLOAT32
        if name in posed.values and differs(posed.values[name], value, relative=accuracy, absolute=1e-7):
            yield Fault(poses.file, seen.name, f"{name} of {thing.path}", text(value), text(posed.values[name]))
    yield from _rotations(seen, poses, posed, thing, camera)
    yield from _pixels(seen, poses, posed, thing, camera)
    yield from _truncated(seen, poses, posed, thing, camera)


def _truncated(seen: Seen, poses: Poses, posed: Posed, thing: Thing, camera: CameraView) -> Faults:
    """The truncation is that of the keypoints, which are in whole pixels; not looked at where some are behind."""
    points = next((posed.values[name] for name in _OF_POINTS if name in posed.values), None)
    if points is None or "truncation_ratio" not in posed.values or _corner_pixels(thing, camera) is None:
        return
    expected = _outside(np.array(points, np.float64).reshape(-1, 2), camera)
    expected = 1.0 if expected is None else expected  # of a line, or a point
    found = float(posed.values["truncation_ratio"])
    if differs(found, expected, relative=0.0, absolute=1e-6):
        yield Fault(poses.file, seen.name, f"truncation_ratio of {thing.path}", f"{expected:.4f}", f"{found:.4f}")


def truncation(thing: Thing, camera: CameraView) -> float | None:
    """Return the fraction of a box's rectangle that is outside the image; None where some of it is behind the lens."""
    corners = _corner_pixels(thing, camera)
    return None if corners is None else _outside(corners, camera)


def _outside(pixels: np.ndarray, camera: CameraView) -> float | None:
    """Return the fraction of the rectangle around pixels that is outside the image; None where it has no area."""
    low, high, size = pixels.min(axis=0), pixels.max(axis=0), np.array([camera.width, camera.height], float)
    inside = np.clip(high, 0, size) - np.clip(low, 0, size)
    return 1.0 - float(np.prod(inside) / np.prod(high - low)) if (high > low).all() else None


def _corner_pixels(thing: Thing, camera: CameraView) -> np.ndarray | None:
    pixels, depth = camera.project(moved(keypoints(thing.bounds, list(_ORDER[1:])), thing.local_to_world))
    if camera.projection_type != "pinhole" or not (depth > max(camera.clipping_range[0], 1e-6)).all():
        return None
    return pixels


def keypoints(bounds: np.ndarray, order: list[str]) -> np.ndarray:
    """Return the center and corners of a box in the frame of its prim, by name, (N, 3)."""

    def corner(name: str) -> np.ndarray:
        if name == "Center":
            return bounds.mean(axis=0)
        return np.array(
            [bounds["LR".index(name[0]), 0], bounds["DU".index(name[1]), 1], bounds["BF".index(name[2]), 2]]
        )

    return np.array([corner(name) for name in order])


def _to_camera(poses: Poses, thing: Thing, camera: CameraView) -> np.ndarray:
    pose = thing.local_to_world
    return pose @ camera.world_to_camera if poses.exact else camera.world_to_camera @ pose


def _values(poses: Poses, thing: Thing, camera: CameraView) -> Mapping[str, Any]:
    """Return what a file must have of an object, by its names."""
    pose, to_camera = thing.local_to_world, _to_camera(poses, thing, camera)
    world = moved(keypoints(thing.bounds, poses.order), pose)
    in_camera = moved(world, camera.world_to_camera)
    size = (thing.bounds[1] - thing.bounds[0]) * np.linalg.norm(pose[:3, :3], axis=1)
    values = {
        "local_to_world_transform": pose,
        "location_world_frame": pose[3, :3],
        "rotation_matrix_world_frame": pose[:3, :3],
        "location_camera_frame": to_camera[3, :3],
        "rotation_matrix_camera_frame": to_camera[:3, :3],
        "location": to_camera[3, :3],
        "cuboid_keypoints_world_frame": world,
        "cuboid_keypoints_camera_frame": in_camera,
        "keypoints_3d": in_camera,
    }
    # The axes of a sheared prim have no lengths of their own.
    return values | (dict.fromkeys(_SIZES, size) if is_straight(pose) else {})


def _rotations(seen: Seen, poses: Poses, posed: Posed, thing: Thing, camera: CameraView) -> Faults:
    """Quaternions turn as the matrices do."""
    frames = {"quat_wxyz_world_frame": thing.local_to_world}
    if poses.exact or is_straight(_to_camera(poses, thing, camera)):
        frames |= dict.fromkeys(("quat_wxyz_camera_frame", "quaternion_xyzw"), _to_camera(poses, thing, camera))
    for name, matrix in frames.items():
        if name not in posed.values or not is_straight(matrix) or np.linalg.det(matrix[:3, :3]) <= 0:
            continue
        axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=1, keepdims=True)
        found = turned(posed.values[name], real_last=name.endswith("xyzw"))
        if differs(found, axes, relative=0.0, absolute=1e-4):
            yield Fault(poses.file, seen.name, f"{name} of {thing.path} turns its axes to", text(axes), text(found))


def turned(quaternion: Any, *, real_last: bool) -> np.ndarray:
    """Return the axes, as rows, that a quaternion turns x, y and z to."""
    parts = np.array(quaternion, np.float64)
    w, (x, y, z) = (parts[3], parts[:3]) if real_last else (parts[0], parts[1:])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
            [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
            [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _pixels(seen: Seen, poses: Poses, posed: Posed, thing: Thing, camera: CameraView) -> Faults:
    """Keypoints project to the pixels of the file, and around the object's own."""
    name = next((each for each in _OF_POINTS if each in posed.values), None)
    if name is None:
        return
    found = np.array(posed.values[name], np.float64)
    world = moved(keypoints(thing.bounds, poses.order), thing.local_to_world)
    pixels, depth = camera.project(world)
    ahead = np.isfinite(pixels).all(axis=1) & (depth > max(camera.clipping_range[0], 1e-6))
    if found.shape != pixels.shape or differs(found[ahead], pixels[ahead], relative=0.0, absolute=_PIXEL):
        yield Fault(poses.file, seen.name, f"{name} of {thing.path}", text(np.rint(pixels)), text(found))
    elif ahead.all() and camera.lens is None and thing.amodal_box is not None:
        low, high = found.min(axis=0) - _REACH, found.max(axis=0) + _REACH
        box = np.array(thing.amodal_box, np.float64).reshape(2, 2) + np.array([[0], [1]])
        if (box[0] < low).any() or (box[1] > high).any():
            yield Fault(
                poses.file,
                seen.name,
                f"{name} of {thing.path} surrounds its pixels",
                str(thing.amodal_box),
                text([*low, *high]),
            )


def _agrees(seen: Seen, poses: Poses, posed: Posed) -> Faults:
    """Whatever is recorded: no value is missing, and quaternions are unit ones, turned as the matrices beside them."""
    if left_out := [name for name in _KEYS.get(poses.format, ()) if name not in posed.values]:
        yield Fault(poses.file, seen.name, f"{posed.path} lacks {', '.join(left_out)}")
    for name, matrix in (
        ("quat_wxyz_world_frame", "rotation_matrix_world_frame"),
        ("quat_wxyz_camera_frame", "rotation_matrix_camera_frame"),
        ("quaternion_xyzw", ""),
    ):
        if name not in posed.values:
            continue
        length = float(np.linalg.norm(posed.values[name]))
        if differs(length, 1.0, relative=0.0, absolute=1e-4):
            yield Fault(poses.file, seen.name, f"{name} of {posed.path} is no rotation", "length 1", f"{length:.6g}")
        if seen.truth is None and matrix in posed.values:
            axes = np.array(posed.values[matrix], np.float64)
            if is_straight(axes) and np.linalg.det(axes) > 0:
                axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
                if differs(turned(posed.values[name], real_last=False), axes, relative=0.0, absolute=1e-4):
                    yield Fault(poses.file, seen.name, f"{name} of {posed.path} is not {matrix}")
    if not 0.0 <= posed.visibility <= 1.0:
        yield Fault(poses.file, seen.name, f"visibility of {posed.path}", "0 to 1", f"{posed.visibility:g}")
    if seen.truth is None:
        yield from _projects(seen, poses, posed)
        yield from _locations(seen, poses, posed)


def _projects(seen: Seen, poses: Poses, posed: Posed) -> Faults:
    """Without a record: keypoints in the camera's frame and in pixels agree by the intrinsics of the file."""
    for points, pixels in (
        ("cuboid_keypoints_camera_frame", "cuboid_keypoints_projected"),
        ("keypoints_3d", "projected_cuboid"),
    ):
        if points not in posed.values or not seen.cameras or seen.cameras[0].center is None:
            continue
        (cx, cy), focal = seen.cameras[0].center, seen.cameras[0].focal or np.nan
        x, y, z = np.array(posed.values[points], np.float64).T
        ahead = z < -1e-3
        with np.errstate(divide="ignore", invalid="ignore"):
            projected = np.stack([cx + focal * x / -z, cy - focal * y / -z], axis=1)
        written = np.array(posed.values[pixels], np.float64)
        if written.shape != projected.shape or beyond(np.abs(projected - written)[ahead], _PIXEL).any():
            yield Fault(poses.file, seen.name, f"{points} of {posed.path} do not project to {pixels}")


def _locations(seen: Seen, poses: Poses, posed: Posed) -> Faults:
    """Without a record: places in both frames are those of the transform, and of the camera's as the file has it."""
    values = posed.values
    if "local_to_world_transform" not in values:
        return
    pose = np.array(values["local_to_world_transform"], np.float64).reshape(4, 4)
    if "location_world_frame" in values and differs(values["location_world_frame"], pose[3, :3], relative=_FLOAT32):
        what = f"location_world_frame of {posed.path} is that of local_to_world_transform"
        yield Fault(poses.file, seen.name, what, text(pose[3, :3]), text(values["location_world_frame"]))
    if "location_camera_frame" not in values or not seen.cameras or seen.cameras[0].view is None:
        return
    found, view = np.array(values["location_camera_frame"], np.float64), seen.cameras[0].view
    # Which of both a file has is not told in it: `exact_camera_frame` is an option of the writer.
    places = [(pose @ view)[3, :3], (view @ pose)[3, :3]]
    rounded = 4 * seen.cameras[0].digits * (1.0 + max(np.abs(pose).max(), np.abs(view).max()))
    if all(differs(found, each, relative=_FLOAT32, absolute=rounded) for each in places):
        what = f"location_camera_frame of {posed.path} is that of local_to_world_transform"
        yield Fault(poses.file, seen.name, what, text(places[0]), text(found))


def moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3] + matrix[3, :3]


def is_straight(matrix: np.ndarray) -> bool:
    """Return whether the axes are perpendicular."""
    axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=1, keepdims=True), 1e-12)
    return bool(np.abs(axes @ axes.T - np.eye(3)).max() < _STRAIGHT)
