"""`isaacsim.replicator.behavior.base_behavior`: a behavior with exposed variables that acts at an interval."""

from __future__ import annotations

import inspect
from typing import Any, ClassVar

from pxr import Sdf

from usdsdg.compat.isaacsim.replicator.behavior.global_variables import EXPOSED_ATTR_NS
from usdsdg.compat.isaacsim.replicator.behavior.utils import behavior_utils
from usdsdg.compat.omni.behavior.scripting.core import BehaviorScript

Variable = dict[str, Any]


def variable(attr_name: str, attr_type: Sdf.ValueTypeName, default_value: Any, doc: str, **more: Any) -> Variable:
    """Return a row of `VARIABLES_TO_EXPOSE`."""
    return {"attr_name": attr_name, "attr_type": attr_type, "default_value": default_value, "doc": doc, **more}


INTERVAL = variable("interval", Sdf.ValueTypeNames.UInt, 0, "Updates between two changes; 0 is every update.")


class BaseBehavior(BehaviorScript):
    """Exposes `VARIABLES_TO_EXPOSE` on its prim, and calls `_apply_behavior` at every `interval`-th update.

    Subclasses define `BEHAVIOR_NS`, the namespace of their variables, and `_apply_behavior`.
    """

    BEHAVIOR_NS: ClassVar[str] = "baseBehavior"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [INTERVAL]

    def on_init(self) -> None:
        self._update_counter = self._interval = 0
        behavior_utils.create_exposed_variables(self.prim, EXPOSED_ATTR_NS, self.BEHAVIOR_NS, self.VARIABLES_TO_EXPOSE)

    def on_destroy(self) -> None:
        """Remove the variables, unless the prim still names the script."""
        if behavior_utils.check_if_exposed_variables_should_be_removed(self.prim, inspect.getfile(type(self))):
            behavior_utils.remove_exposed_variables(
                self.prim, EXPOSED_ATTR_NS, self.BEHAVIOR_NS, self.VARIABLES_TO_EXPOSE
            )

    def on_play(self) -> None:
        self._interval = self._get_exposed_variable("interval")

    def on_stop(self) -> None:
        self._update_counter = self._interval = 0

    def on_update(self, current_time: float, delta_time: float) -> None:
        if delta_time <= 0.0:
            return
        self._update_counter += 1
        if self._update_counter >= self._interval:
            self._update_counter = 0
            self._apply_behavior()

    def _apply_behavior(self) -> None:
        raise NotImplementedError(f"{type(self).__name__} has no _apply_behavior")

    def _get_exposed_variable(self, attr_name: str) -> Any:
        name = f"{EXPOSED_ATTR_NS}:{self.BEHAVIOR_NS}:{attr_name}"
        return behavior_utils.get_exposed_variable(self.prim, name)
