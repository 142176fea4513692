"""Which views are drawn together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg_render.path.film import Film

# Of the label pass in one launch; all AOVs take about 100 bytes of each.
LABEL_PIXELS = 1 << 24

# Of masks at once, one gprim in one picture each; they take about 2 kB of memory on average.
MASKS = 1 << 16


def alike(views: Sequence[CameraView], films: Sequence[Film] = ()) -> list[list[int]]:
    """Indices of views that may be drawn in one launch: of one size and stage, with films that hold the same sums."""
    groups: dict[tuple[float | bool, ...], list[int]] = {}
    for k, view in enumerate(views):
        sums = (films[k].has_features, films[k].has_light_aovs) if films else ()
        groups.setdefault((view.width, view.height, view.meters_per_unit, *sums), []).append(k)
    return list(groups.values())


def of_labels(views: Sequence[CameraView]) -> list[list[int]]:
    """As `alike`, no more at once than memory has room for."""
    batches = []
    for places in alike(views):
        most = max(1, LABEL_PIXELS // (views[places[0]].width * views[places[0]].height))
        batches += [places[first : first + most] for first in range(0, len(places), most)]
    return batches


def of_masks(pictures: int, gprims: int) -> list[range]:
    """Which pictures have their masks made together, no more at once than memory has room for."""
    most = max(1, MASKS // max(1, gprims))
    return [range(first, min(first + most, pictures)) for first in range(0, pictures, most)]
