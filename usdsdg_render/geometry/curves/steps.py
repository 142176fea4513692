"""How many samples the segments of curves need, so that the chords between these stay close to the curve."""

from collections.abc import Sequence

import numpy as np

from usdsdg_render.geometry.curves.polylines import Polylines

# Distance of a chord from its curve, as a share of the curve's radius and of its extent: the larger one counts. A
# smaller one is not seen where the tube is drawn or where the curve spans 2,000 pixels.
RADIUS_SHARE, EXTENT_SHARE = 0.05, 1 / 2_000
# No prim gets more samples than these make of it, beside those of `tubes.TUBES`.
MOST_STEPS, MOST_TRIANGLES = 64, 512_000


def count_triangles(groups: Sequence[Polylines], sides: int) -> int:
    """Return about how many triangles the tubes of curves have."""
    return 2 * sides * sum(each.points.shape[0] * each.points.shape[1] for each in groups)


def most_doublings(groups: Sequence[Polylines], sides: int) -> int:
    """Return how often the samples of the segments of curves may be doubled."""
    bent = [each for each in groups if each.steps > 1]
    triangles = count_triangles(groups, sides)
    if not bent or not triangles:
        return 0
    factor = min(MOST_TRIANGLES / triangles, MOST_STEPS / max(each.steps for each in bent))
    return int(np.log2(factor)) if factor >= 2.0 else 0


def wanted_doublings(groups: Sequence[Polylines]) -> int:
    """Return how often the samples of segments should be doubled: half as long, chords are four times as close."""
    excess = max((_excess(each) for each in groups), default=0.0)
    return int(np.ceil(np.log2(excess) / 2.0)) if excess > 1.0 else 0


def _excess(polylines: Polylines) -> float:
    """The largest distance of a chord from its curve, over the one that is allowed."""
    points, steps = polylines.points, polylines.steps
    inner = np.arange(1, points.shape[1] - 1)
    inner = inner[inner % steps != 0]  # segments may meet at an angle, which no number of samples changes
    if not len(inner):
        return 0.0
    # The second difference is the second derivative, and an eighth of it the height of an arc over its chord.
    height = (
        np.linalg.norm(points[:, inner - 1] - 2.0 * points[:, inner] + points[:, inner + 1], axis=2).max(axis=1) / 8
    )
    extent = np.ptp(points, axis=1).max(axis=1)
    allowed = np.maximum(RADIUS_SHARE * polylines.radii.max(axis=1), EXTENT_SHARE * extent)
    return float((height / allowed).max())
