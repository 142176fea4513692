"""`RobotView`: an `Articulation` by another name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from usdsdg.compat.isaacsim.core.prims import Articulation

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values


class RobotView(Articulation):
    """Several robots."""

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "robot_view",
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
    ) -> None:
        """Wrap robots; see `Articulation`."""
        super().__init__(prim_paths_expr, name, positions, translations, orientations, scales, visibilities)
