"""`Robot`: a `SingleArticulation` by another name."""

from __future__ import annotations

from collections.abc import Sequence

from usdsdg.compat.isaacsim.core.api.controllers import ArticulationController
from usdsdg.compat.isaacsim.core.prims import SingleArticulation


class Robot(SingleArticulation):
    """One robot."""

    def __init__(
        self,
        prim_path: str,
        name: str = "robot",
        position: Sequence[float] | None = None,
        translation: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        scale: Sequence[float] | None = None,
        visible: bool | None = None,
        articulation_controller: ArticulationController | None = None,
    ) -> None:
        """Wrap a prim; see `SingleArticulation`."""
        super().__init__(
            prim_path, name, position, translation, orientation, scale, visible,
            articulation_controller=articulation_controller,
        )  # fmt: skip
