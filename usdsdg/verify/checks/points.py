"""Point clouds: a point for each labeled pixel, where depth has it, with the pixel's ids."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Points, Seen
from usdsdg.datasets.truth import points
from usdsdg.errors import counted
from usdsdg.record import samples
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import beyond, text

_RELATIVE = 5e-5  # of the largest coordinate, and the place of the camera
# Along the line of sight, where a rounding moves the points of surfaces that are seen edge-on.
_ALONG = 2e-3


def check(seen: Seen) -> Faults:
    """Compare point clouds with the record."""
    for cloud in seen.points:
        for file, values in cloud.others.values():
            if len(values) != len(cloud.points):
                yield Fault(
                    file,
                    seen.name,
                    f"rows are as many as those of {cloud.file}",
                    str(len(cloud.points)),
                    str(len(values)),
                )
        if seen.truth is not None:
            yield from _recorded(seen, cloud)


def _recorded(seen: Seen, cloud: Points) -> Faults:
    assert seen.truth is not None
    truth, members = seen.truth, seen.truth.members(cloud.filter)
    if members is None or truth.camera is None:
        return
    kept = members >= (-1 if cloud.whole else 0)
    if kept.sum() != len(cloud.points):
        yield Fault(
            cloud.file,
            seen.name,
            "there is a point for each labeled pixel",
            str(int(kept.sum())),
            str(len(cloud.points)),
        )
        return
    rows, columns = truth.grid
    if truth.grid_points is not None:
        place = np.cumsum(kept.ravel()).reshape(kept.shape) - 1
        here = kept[rows, columns]
        found, expected = cloud.points[place[rows, columns][here]], truth.grid_points[here]
        if are_elsewhere(found, expected, truth.camera):
            worst = int(np.abs(found - expected).max(axis=1).argmax())
            yield Fault(
                cloud.file, seen.name, "a point is not where depth has it", text(expected[worst]), text(found[worst])
            )
    yield from _of_files(seen, cloud, kept)
    things = truth.things(cloud.filter)
    for kind, name in (("semantic", "class_id"), ("instance", "id")):
        if kind in cloud.others:
            file, values = cloud.others[kind]
            table = np.array([*(getattr(each, name) for each in things), 1])  # unlabeled
            if len(values) == len(cloud.points) and (values != table[members[kept]]).any():
                wrong = int((values != table[members[kept]]).sum())
                yield Fault(file, seen.name, f"the ids of {counted(wrong, 'point')} are not those of what is there")
    if "rgb" in cloud.others and seen.colors and seen.colors[0].exact and seen.colors[0].image.shape[:2] == kept.shape:
        file, values = cloud.others["rgb"]
        channels = min(values.shape[1], seen.colors[0].image.shape[2])
        mine, theirs = values[:, :channels], seen.colors[0].image[kept][:, :channels]
        if len(values) == len(cloud.points) and (mine != theirs).any():
            yield Fault(file, seen.name, f"points have not the colors of {seen.colors[0].file}")
    if "normals" in cloud.others and truth.product.normals is not None:
        file, values = cloud.others["normals"]
        place, here = np.cumsum(kept.ravel()).reshape(kept.shape) - 1, kept[rows, columns]
        if len(values) == len(cloud.points):
            off = np.abs(values[place[rows, columns][here]][:, :3] - truth.product.normals[here] / 127.0)
            if (wrong := beyond(off, 1 / 127)).any():
                yield Fault(
                    file,
                    seen.name,
                    f"normals of {counted(int(wrong.any(axis=1).sum()), 'point')} are not the recorded ones",
                )


def are_elsewhere(found: np.ndarray, expected: np.ndarray, camera: CameraView) -> bool:
    """Return whether points (N, 3) in the world are not where they are expected."""
    eye = camera.local_to_world[3, :3]
    scale = np.abs(expected).max(initial=0) + np.linalg.norm(eye)
    sight = expected - eye
    sight /= np.maximum(np.linalg.norm(sight, axis=1, keepdims=True), 1e-30)
    off = found - expected
    along = (off * sight).sum(axis=1)
    across = np.linalg.norm(off - along[:, None] * sight, axis=1)
    return bool(beyond(across, _RELATIVE * scale).any() or beyond(np.abs(along), _ALONG * scale).any())


def _of_files(seen: Seen, cloud: Points, kept: np.ndarray) -> Faults:
    """Points and their normals are those of the depth and the normals that were written beside them."""
    assert seen.truth is not None
    camera = seen.truth.camera
    assert camera is not None
    depth = next((each for each in seen.depths if each.kind == "camera" and each.values.shape == kept.shape), None)
    if depth is not None:
        rows, columns = np.nonzero(kept)
        expected = points(camera, depth.values[kept].astype(np.float64), rows, columns)
        if are_elsewhere(cloud.points, expected, camera):
            yield Fault(cloud.file, seen.name, f"points are not where {depth.file} has them")
    image = next((each for each in seen.normals if each.exact and each.image.shape[:2] == kept.shape), None)
    if image is not None and "normals" in cloud.others:
        file, values = cloud.others["normals"]
        if len(values) == len(cloud.points) and (samples.normal_image(values) != image.image[kept][:, :3]).any():
            yield Fault(file, seen.name, f"normals are not those of {image.file}")
