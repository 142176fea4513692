"""How much of objects a camera sees, measured by the rays that labels come from, in a smaller picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pxr import Usd

from usdsdg.scenarios.gprims import rows_below
from usdsdg.session import engines
from usdsdg.stage.cameras.camera_view import read_camera

# Shorter side of the pictures that are measured: a hundredth of a large object, a tenth of a small one.
_SIDE = 120


@dataclass(frozen=True)
class Seen:
    """Fractions of an object, of what it would cover alone in and around the picture."""

    occlusion: float  # hidden by others, of what is inside of the picture
    truncation: float  # outside of the picture
    pixels: int  # visible ones of the measured picture


def measure(camera: Usd.Prim, size: tuple[int, int], prims: Sequence[Usd.Prim]) -> list[Seen]:
    """Return how much is seen of each prim with all below it, as the stage is now."""
    factor = max(min(size) / _SIDE, 1.0)
    small = (max(round(size[0] / factor), 1), max(round(size[1] / factor), 1))
    view = read_camera(camera.GetStage(), camera.GetPath(), small)
    renderer = engines.renderer()
    renderer.sync()
    groups = rows_below(renderer.gprims, prims)
    masks = renderer.labels_and_masks([view], ("instance",), groups)[1][0]
    around = renderer.coverage_around(view, groups)[:, 0]
    found = []
    for inside, visible, outside in zip(masks.coverage[:, 0].tolist(), masks.visible.tolist(), around.tolist()):
        whole = inside + outside
        found.append(Seen(1.0 - visible / inside if inside else 1.0, outside / whole if whole else 1.0, visible))
    return found
