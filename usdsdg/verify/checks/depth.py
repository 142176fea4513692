"""Depth: the rendered one, its two kinds in agreement, and seen from other cameras at the same places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Depth, Seen
from usdsdg.datasets.truth import Truth, plane_depth
from usdsdg.record import samples
from usdsdg.verify.checks.compare import of_pixels, shapes_agree

_AOVS = {"camera": "distance_to_camera", "plane": "distance_to_image_plane"}
_RELATIVE = 2e-5
# Of another camera's points: how much nearer than the surface they may be, and the fraction that may be odd, as at
# silhouettes and what is thinner than a pixel.
_NEARER, _ODD = 0.02, 0.05
_FEWEST = 20
# Depths whose ratio is below this are one distance; the relative error of a logarithm of their ratios in 32 bits.
_ONE_DISTANCE, _ROUNDING = 1 + 1e-5, 2.0**-22


def check(seen: Seen) -> Faults:
    """Compare depth with the record, with the other kind, and with what other cameras saw."""
    for depth in seen.depths:
        if seen.truth is None:
            continue
        yield from shapes_agree(seen, depth.file, depth.values.shape, seen.truth.product.shape)
        if depth.values.shape == seen.truth.product.shape:
            yield from _recorded(seen, depth, seen.truth)
            yield from _from_others(seen, depth, seen.truth)
    yield from _kinds_agree(seen)
    for file, image, values in seen.extra.get("drawn depth", []):
        levels = image.astype(int)
        wrong, *_ = sorted((np.abs(levels - gray) > off for gray, off in _grays(values)), key=np.count_nonzero)
        if wrong.any():
            yield Fault(file, seen.name, f"the gray image is not that of the depth in {of_pixels(wrong)}")


def _recorded(seen: Seen, depth: Depth, truth: Truth) -> Faults:
    name = _AOVS[depth.kind]
    known = None if depth.step else truth.product.checksums.get(name)
    if known is not None and samples.checksum(depth.values.astype(np.float32)) == known:
        return
    expected = truth.product.depth if depth.kind == "camera" else truth.plane_depth
    if expected is None:
        return
    found = samples.grid(depth.values)
    wrong = _wrong(found, expected, depth)
    if wrong.any():
        rows, columns = truth.grid
        at = np.argwhere(wrong)[0]
        where = f"column {columns[tuple(at)]} of row {rows[tuple(at)]}"
        yield Fault(
            depth.file, seen.name, f"depth differs in {int(wrong.sum())} of {wrong.size} places, first in {where}",
            f"{expected[tuple(at)]:.6g} m", f"{found[tuple(at)]:.6g} m",
        )  # fmt: skip
    elif known is not None:
        yield Fault(depth.file, seen.name, "depth is not the rendered one, byte for byte")


def _wrong(found: np.ndarray, expected: np.ndarray, depth: Depth, distance: np.ndarray | None = None) -> np.ndarray:
    """Return where depths are not the expected ones. distance: what they are computed of; default they themselves."""
    seen = np.isfinite(expected) & (expected <= depth.far)
    off = np.abs(np.where(np.isfinite(found), found, 0) - np.where(seen, expected, 0))
    limit = depth.step * 0.501 + _RELATIVE * np.where(seen, np.abs(expected if distance is None else distance), 0)
    # At the end of its range a format may have either, and less than half a step is 0 in it, as what is not seen.
    near_the_end = np.abs(np.where(np.isfinite(expected), expected, 0) - depth.far) <= depth.step
    either = near_the_end | (~np.isfinite(found) & (expected <= depth.step * 0.501) & (depth.step > 0))
    return (((np.isfinite(found) != seen) | (seen & (off > limit))) & ~either) | np.isnan(found)


def _kinds_agree(seen: Seen) -> Faults:
    kinds = {each.kind: each for each in seen.depths}
    camera = seen.truth.camera if seen.truth else None
    if len(kinds) < 2 or camera is None or kinds["camera"].values.shape != kinds["plane"].values.shape:
        return
    along, plane = kinds["camera"], kinds["plane"]
    rows, columns = samples.grid_pixels(along.values.shape)
    if along.values.shape != (camera.height, camera.width):
        return
    distance = samples.grid(along.values).astype(np.float64)
    # Of a ray that is perpendicular to the axis, as fisheyes have them, the depth is 0, and rounded as the distance is.
    if _wrong(samples.grid(plane.values), plane_depth(camera, distance, rows, columns), plane, distance).any():
        yield Fault(plane.file, seen.name, f"the distance along the optical axis is not that of {along.file}")


def _from_others(seen: Seen, depth: Depth, truth: Truth) -> Faults:
    """No surface is farther than a point on the same ray that another camera saw."""
    camera = truth.camera
    if camera is None or depth.kind != "camera":
        return
    for product in truth.record.products:
        other = Truth(truth.record, product)
        if product.name == truth.product.name or other.grid_points is None:
            continue
        points = other.grid_points.reshape(-1, 3)
        points = points[np.isfinite(points).all(axis=1)]
        pixels, _ = camera.project(points)
        column, row = (np.floor(np.nan_to_num(each, nan=-1.0, posinf=-1.0, neginf=-1.0)) for each in pixels.T)
        inside = (column >= 1) & (column < camera.width - 1) & (row >= 1) & (row < camera.height - 1)
        if inside.sum() < _FEWEST:
            continue
        origin = camera.local_to_world[3, :3]
        distance = np.linalg.norm(points[inside] - origin, axis=1) * camera.meters_per_unit
        around = [
            depth.values[row[inside].astype(int) + down, column[inside].astype(int) + right]
            for down in (-1, 0, 1) for right in (-1, 0, 1)
        ]  # fmt: skip
        near, far = (camera.clipping_range[side] * camera.meters_per_unit for side in (0, 1))
        odd = (np.min(around, axis=0) > distance * (1 + _NEARER)) & (distance > near * 1.01) & (distance < far)
        if odd.mean() > _ODD:
            yield Fault(
                depth.file, seen.name, f"points that {product.name} saw are in front of the surface here",
                f"none of {int(inside.sum())}", f"{int(odd.sum())}",
            )  # fmt: skip


def _grays(depth: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
    """Yield gray levels of depth [m] and how far off they may be, over the ranges that writers have had.

    These are the depth's own, in which one distance is white also where its rounding differs, and 0.00001 to 100 m of
    datasets before version 0.2.
    """
    finite = depth[np.isfinite(depth) & (depth > 0)].astype(np.float64)
    near, far = (finite.min(), finite.max()) if finite.size else (1e-5, 100.0)
    end = far if far > near * _ONE_DISTANCE else near * 2.0
    # Writers compute in 32 bits, whose rounding counts more the narrower the range is.
    yield _gray(depth, near, end), 1 + _ROUNDING * 255 / np.log(end / near)
    yield _gray(depth, 1e-5, 100.0), 1


def _gray(depth: np.ndarray, near: float, far: float) -> np.ndarray:
    """Return depth [m] as gray levels: white at `near`, black at `far`, on a logarithmic scale."""
    fraction = np.log(np.clip(depth.astype(np.float64), near, far) / near) / np.log(far / near)
    return np.floor(np.clip(1.0 - fraction, 0, 1) * 255 + 1e-6).astype(int)
