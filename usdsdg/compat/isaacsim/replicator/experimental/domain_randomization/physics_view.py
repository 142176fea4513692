"""`isaacsim.replicator.experimental.domain_randomization.physics_view`: views are registered by a name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from usdsdg.compat.isaacsim.replicator.randomization.physics_view import (
    randomize_articulation_view,
    randomize_rigid_prim_view,
    randomize_simulation_context,
    step_randomization,
)
from usdsdg.compat.isaacsim.replicator.randomization.registry import get_registry

__all__ = [
    "randomize_articulation_view", "randomize_rigid_prim_view", "randomize_simulation_context",
    "register_articulation_view", "register_rigid_prim_view", "register_simulation_context", "step_randomization",
]  # fmt: skip


class View(Protocol):
    """A wrapper of `isaacsim.core.experimental.prims`."""

    @property
    def paths(self) -> Sequence[str]: ...


def register_simulation_context(simulation_context: object = None) -> None:
    """Register the gravity of the stage's PhysicsScene, which is that of `SimulationManager`."""
    get_registry().register_scene()


def register_rigid_prim_view(rigid_prim_view: View, name: str) -> None:
    """Register rigid bodies; their present poses and velocities are what additive and scaling start from."""
    get_registry().register_rigid(name, [str(path) for path in rigid_prim_view.paths])


def register_articulation_view(articulation_view: View, name: str) -> None:
    """Register articulations, likewise.

    Raises:
        BadPrim: one has no joint between two bodies.
    """
    get_registry().register_robots(name, [str(path) for path in articulation_view.paths])
