"""`omni.physics.core`: physics step events, as Isaac Sim 6 names them."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from usdsdg.compat.omni.physx import Subscription
from usdsdg.errors import Unsupported
from usdsdg.session import engines


class PhysicsSimulationInterface:
    def subscribe_physics_on_step_events(
        self, pre_step: bool = False, order: int = 0, on_update: Callable[[float, Any], None] | None = None
    ) -> Subscription:
        """Call `on_update(dt, context)` after every physics step; listeners are called in the order of subscription.

        Raises:
            Unsupported: `pre_step`, since poses are read and written once per step, after it.
        """
        if pre_step:
            raise Unsupported("subscribe_physics_on_step_events: pre_step=True is not available; use pre_step=False")
        if on_update is None:
            raise TypeError("subscribe_physics_on_step_events: on_update is missing")
        return Subscription(engines.subscribe_step(lambda dt: on_update(dt, SimpleNamespace(simulation_id=0))))


_interface = PhysicsSimulationInterface()


def get_physics_simulation_interface() -> PhysicsSimulationInterface:
    return _interface
