"""A behavior that only prints."""

from pxr import Usd

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, PrimsBehavior


class ExampleBehavior(PrimsBehavior):
    """Prints the prims that it acts on."""

    BEHAVIOR_NS = "exampleBehavior"
    VARIABLES_TO_EXPOSE = [INTERVAL, INCLUDE_CHILDREN]

    def _applies_to(self, prim: Usd.Prim) -> bool:
        return True

    def _apply_behavior(self) -> None:
        for prim in self._valid_prims:
            print(f"[{type(self).__name__}][{self.prim_path}] acts on {prim.GetPath()}")
