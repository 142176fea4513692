"""DOPE: the right objects with their poses and keypoints, and cuboids that poses and intrinsics can project."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.dope import NAME, ORDER, Posed, Poses
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.poses.rotations import matrix_from_euler
from usdsdg.verify.checks.compare import beyond, differs, text
from usdsdg.verify.checks.poses import is_straight, keypoints, moved, turned

_BOXES, _NODE = "bounding_box_3d", "dope"
_OPENCV = (180.0, 0.0, 0.0)
_FLOAT32 = 4e-6
_PIXEL = 0.05
_CENTIMETERS = 100.0


def check(seen: Seen) -> Faults:
    """Check the objects of an image."""
    poses: Poses | None = seen.extra.get("poses") if seen.format == NAME else None
    if poses is None:
        return
    for each in poses.objects:
        yield from _agrees(seen, poses, each)
    if poses.exact and seen.size is not None and (poses.camera["width"], poses.camera["height"]) != seen.size:
        found = f"{poses.camera['width']} x {poses.camera['height']}"
        yield Fault(poses.file, seen.name, "the size is not that of the image", "{} x {}".format(*seen.size), found)
    if seen.truth is not None and seen.truth.camera is not None:
        yield from _recorded(seen, poses, seen.truth, seen.truth.camera)


def _agrees(seen: Seen, poses: Poses, posed: Posed) -> Faults:
    """Whatever is recorded: a unit quaternion, a fraction, and keypoints that are those of a box with this pose."""
    if differs(np.linalg.norm(posed.quaternion), 1.0, relative=0.0, absolute=1e-4):
        yield Fault(
            poses.file, seen.name, f"quaternion_wxyz of {posed.name} is no rotation", "", text(posed.quaternion)
        )
    if not -1e-6 <= posed.visibility <= 1.0 + 1e-6:
        yield Fault(poses.file, seen.name, f"visibility of {posed.name}", "0 to 1", f"{posed.visibility:g}")
    camera = None if seen.truth is None else seen.truth.camera
    # Intrinsics do not describe other lenses; keypoints are compared with the record then.
    if camera is not None and (camera.projection_type != "pinhole" or camera.lens is not None):
        return
    if not poses.exact or seen.size is None or not ((posed.pixels > 0) & (posed.pixels < seen.size)).all():
        return
    if seen.truth is not None and _may_be_bent(posed, seen.truth):
        return
    off = _off_any_box(posed, poses.camera["intrinsics"])
    if beyond(off, _PIXEL):
        yield Fault(
            poses.file, seen.name, f"projected_cuboid of {posed.name} is of a box with its quaternion",
            "0 pixels off", f"{off:.2f}",
        )  # fmt: skip


def _may_be_bent(posed: Posed, truth: Truth) -> bool:
    """Return whether an object of this name is sheared or mirrored, which the writer has warned of."""
    things = truth.things(truth.filter_of(_BOXES))
    return any(_name(each) == posed.name and not _is_rigid(each.local_to_world) for each in things)


def _is_rigid(pose: np.ndarray) -> bool:
    return is_straight(pose) and bool(np.linalg.det(pose[:3, :3]) > 0)


def _off_any_box(posed: Posed, k: Mapping[str, float]) -> float:
    """Return how far keypoints are from those of the turned box, wherever and of whatever size, that fits [pixels]."""
    axes = turned(posed.quaternion, real_last=False)  # rows
    signs = keypoints(np.array([[-0.5] * 3, [0.5] * 3]), list(ORDER))
    rays = (posed.pixels - (k["cx"], k["cy"])) / (k["fx"], k["fy"])
    # A keypoint is at center + (sign * size) @ axes; on its ray are two equations of the six unknowns, up to a factor.
    rows = []
    for sign, ray in zip(signs, rays):
        linear = np.concatenate([np.eye(3), sign[:, None] * axes])  # (6, 3)
        rows += [linear[:, axis] - ray[axis] * linear[:, 2] for axis in (0, 1)]
    found = np.linalg.svd(np.array(rows))[2][-1]
    found *= np.sign(found[2]) or 1.0
    points = found[:3] + (signs * found[3:]) @ axes
    if (points[:, 2] <= 0).any() or (found[3:] < -1e-6).any():
        return np.inf
    pixels = points[:, :2] / points[:, 2:] * (k["fx"], k["fy"]) + (k["cx"], k["cy"])
    return float(np.abs(pixels - posed.pixels).max())


def _recorded(seen: Seen, poses: Poses, truth: Truth, camera: CameraView) -> Faults:
    key = truth.filter_of(_BOXES if poses.exact else _NODE)
    left = [each for each in truth.things(key) if each.amodal]
    if poses.exact:
        k = poses.camera["intrinsics"]
        expected, found = (camera.fx, camera.fy, camera.cx, camera.cy), [k[name] for name in ("fx", "fy", "cx", "cy")]
        if camera.projection_type == "pinhole" and differs(found, expected, relative=1e-6):
            yield Fault(poses.file, seen.name, "intrinsics [pixels]", text(expected), text(found))
    for posed in poses.objects:
        same = [each for each in left if _name(each) == posed.name]
        if not same:
            yield Fault(poses.file, seen.name, f"an object {posed.name} is not in view, or listed too often")
            continue
        thing = min(
            same, key=lambda each: float(np.abs(_pose(poses, truth, camera, each)[3, :3] - posed.location).max())
        )
        left.remove(thing)
        yield from _object(seen, poses, posed, thing, truth, camera)
    for thing in left:
        yield Fault(poses.file, seen.name, f"{thing.path} is in view and is not listed")


def _name(thing: Thing) -> str:
    label = thing.labels.get("class", "") or ",".join(thing.labels.values())
    return "0" + label.lstrip("_") if label.startswith("_") else label


def _object(seen: Seen, poses: Poses, posed: Posed, thing: Thing, truth: Truth, camera: CameraView) -> Faults:
    visibility = 1.0 - (thing.occlusion or 0.0)
    if differs(posed.visibility, visibility, relative=0.0, absolute=1e-5):
        found = f"{posed.visibility:.4f}"
        yield Fault(poses.file, seen.name, f"visibility of {thing.path}", f"{visibility:.4f}", found)
    pose = _pose(poses, truth, camera, thing)
    if differs(posed.location, pose[3, :3], relative=_FLOAT32, absolute=1e-4):
        what = f"location of {thing.path}"
        yield Fault(poses.file, seen.name, what, text(pose[3, :3]), text(posed.location))
    axes = pose[:3, :3] / np.linalg.norm(pose[:3, :3], axis=1, keepdims=True)
    if _is_rigid(pose):
        found = turned(posed.quaternion, real_last=False)
        if differs(found, axes, relative=0.0, absolute=1e-4):
            yield Fault(
                poses.file, seen.name, f"quaternion_wxyz of {thing.path} turns its axes to", text(axes), text(found)
            )
    yield from _pixels(seen, poses, posed, thing, truth, camera)


def _turn(poses: Poses, truth: Truth) -> np.ndarray:
    """Return the turn (4, 4), for row vectors, from USD's camera to the one of the file."""
    given = None if poses.exact else truth.parameter(_NODE, "cameraRotation")
    turn = np.eye(4)
    turn[:3, :3] = matrix_from_euler(_OPENCV if given is None else given)
    return turn


def _pose(poses: Poses, truth: Truth, camera: CameraView, thing: Thing) -> np.ndarray:
    """Return the matrix of an object in the file's camera, with the location in its units."""
    pose = thing.local_to_world @ camera.world_to_camera @ _turn(poses, truth)
    pose[3, :3] *= _CENTIMETERS * (camera.meters_per_unit if poses.exact else 1.0)
    return pose


def _pixels(seen: Seen, poses: Poses, posed: Posed, thing: Thing, truth: Truth, camera: CameraView) -> Faults:
    """Keypoints in front of the camera are where the box's corners are seen."""
    if camera.projection_type != "pinhole" and not poses.exact:
        return
    world = moved(keypoints(thing.bounds, list(ORDER)), thing.local_to_world)
    pixels, depth = camera.project(world)
    if not poses.exact:
        world[8] = thing.local_to_world[3, :3]
        size = [float(truth.parameter(_NODE, name) or 0) for name in ("width", "height")]
        depth = -moved(world, camera.world_to_camera)[:, 2]
        clip = np.column_stack([moved(world, camera.world_to_camera), np.ones(9)]) @ camera.projection_matrix
        clip = clip @ _turn(poses, truth)
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = (clip[:, :2] / clip[:, 3:] + 1) / 2 * (size[0] or camera.width, size[1] or camera.height)
    ahead = (depth > max(camera.clipping_range[0], 1e-6)) & np.isfinite(pixels).all(axis=1)
    off = beyond(np.abs(posed.pixels - pixels), _PIXEL + _FLOAT32 * np.abs(pixels))
    if off[ahead].any():
        what = f"projected_cuboid of {thing.path}"
        yield Fault(poses.file, seen.name, what, text(pixels[ahead]), text(posed.pixels[ahead]))
