"""`BaseSensor`: what sensors that scripts define themselves derive from."""

from __future__ import annotations

from typing import Any

from usdsdg.compat.isaacsim.core.prims.single_xform_prim import SingleXFormPrim


class BaseSensor(SingleXFormPrim):
    """A prim with a pose, which a scene initializes and resets with its other objects."""

    def __init__(self, prim_path: str, name: str = "base_sensor", **pose: Any) -> None:
        """Wrap or define the prim; `pose` are the other arguments of `SingleXFormPrim`, such as `translation`."""
        super().__init__(prim_path, name=name, **pose)
