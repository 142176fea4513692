"""Circles along curves whose hull is a tube: one at each sample, and several where the curve turns sharply.

One circle that halves the angle of two chords would make the tube thinner along both of them, the more the sharper
they turn. So there is one at the end of each chord, orthogonal to it, and some between: outside they are a ball.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from usdsdg_render.geometry.curves.polylines import Polylines
from usdsdg_render.geometry.curves.steps import MOST_TRIANGLES, count_triangles

# Turns up to this are one circle [radians]: they make a tube thinner by less than a hundredth.
LARGEST_TURN = 0.25
# Circles of one sample are so far apart [radii]: where two of them cross, no triangle between them is without an area,
# and a curve that deforms keeps its triangles.
_APART = 1e-3
_UP = np.array([0.0, 0.0, 1.0])


class Sections(NamedTuple):
    """The circles of curves that have equally many."""

    points: np.ndarray  # (C, S, 3) float64 centers
    radii: np.ndarray  # (C, S)
    tangents: np.ndarray  # (C, S, 3) unit normals of their planes, along the curve
    along: np.ndarray  # (S,) samples before each, of those that the curve has


def section_counts(groups: Sequence[Polylines], sides: int) -> list[np.ndarray]:
    """Return the number of circles at each sample of the curves of each group, (K,); one where they are too many."""
    ones = [np.ones(each.points.shape[1], np.int64) for each in groups]
    if count_triangles(groups, sides) > MOST_TRIANGLES:
        return ones
    counts = [_counts(each, sides) for each in groups]
    triangles = 2 * sides * sum(len(each.points) * int(count.sum()) for each, count in zip(groups, counts))
    return counts if triangles <= MOST_TRIANGLES else ones


def sections_of(polylines: Polylines, counts: np.ndarray) -> Sections:
    """Return `counts` (K,) circles at each sample of the curves."""
    sample = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(sample)) - np.repeat(np.cumsum(counts) - counts, counts)
    points, radii = polylines.points[:, sample], polylines.radii[:, sample]
    tangents = _mean_tangents(polylines)[:, sample]
    turned = counts[sample] > 1
    if turned.any():
        before, after, angle = _turns(polylines)
        share = number[turned] / (counts[sample[turned]] - 1)
        here = sample[turned]
        directions = _rotated(before[:, here], after[:, here], share * angle[:, here])
        is_turn = angle[:, here, None] > 0.0
        tangents[:, turned] = np.where(is_turn, directions, tangents[:, turned])
        apart = _APART * radii[:, turned] * (2.0 * share - 1.0)
        points[:, turned] += tangents[:, turned] * apart[..., None]
    return Sections(points, radii, tangents, sample)


def unit(vectors: np.ndarray, fallback: np.ndarray) -> np.ndarray:
    """Return unit vectors; `fallback` for those of zero length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-12, vectors / np.where(length > 1e-12, length, 1.0), fallback)


def _counts(polylines: Polylines, sides: int) -> np.ndarray:
    angle = _turns(polylines)[2].max(axis=0)
    # Circles turn from one to the next by no more than the sides of a tube do.
    return np.where(angle > LARGEST_TURN, 1 + np.ceil(angle / (2 * np.pi / sides)), 1).astype(np.int64)


def _mean_tangents(polylines: Polylines) -> np.ndarray:
    """(C, K, 3) unit tangents at the samples, those of both chords together."""
    point = polylines.points
    if polylines.closed:
        along = np.roll(point, -1, axis=1) - np.roll(point, 1, axis=1)
    else:
        along = np.gradient(point, axis=1) if point.shape[1] > 1 else np.zeros_like(point)
    return unit(along, _UP)


def _turns(polylines: Polylines) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(C, K, 3) unit directions before and after each sample, and (C, K) angles between them: 0 at ends of curves."""
    point = polylines.points
    chord = np.roll(point, -1, axis=1) - point
    after = unit(chord, np.zeros(3))
    # A sample at the place of the next one has the direction that follows, so that curves turn once there.
    count = point.shape[1]
    if not after[:, : count if polylines.closed else count - 1].any(axis=2).all():
        for k in range(-2, -2 * count, -1) if polylines.closed else range(count - 3, -1, -1):
            here = after[:, k % count]
            after[:, k % count] = np.where(here.any(axis=1, keepdims=True), here, after[:, (k + 1) % count])
    before = np.roll(after, 1, axis=1)
    cosine, sine = np.einsum("cki,cki->ck", before, after), np.linalg.norm(np.cross(before, after), axis=-1)
    angle = np.arctan2(sine, cosine)
    if not polylines.closed:
        angle[:, [0, -1]] = 0.0
    return before, after, angle


def _rotated(before: np.ndarray, after: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(C, S, 3) unit vectors `before`, rotated by `angle` (C, S) toward `after`."""
    aside = after - before * np.einsum("cki,cki->ck", before, after)[..., None]
    least = np.eye(3)[np.argmin(np.abs(before), axis=-1)]  # for a curve that turns back
    aside = unit(aside, unit(np.cross(before, least), _UP))
    return before * np.cos(angle)[..., None] + aside * np.sin(angle)[..., None]
