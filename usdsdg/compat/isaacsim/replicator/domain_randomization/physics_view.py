"""`isaacsim.replicator.domain_randomization.physics_view`: views are registered by their own names."""

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


class NamedView(Protocol):
    """A view of `isaacsim.core.prims`."""

    @property
    def name(self) -> str: ...

    @property
    def prim_paths(self) -> Sequence[str]: ...


def register_simulation_context(simulation_context: object = None) -> None:
    """Register the gravity of the stage's PhysicsScene, which is that of every world."""
    get_registry().register_scene()


def register_rigid_prim_view(rigid_prim_view: NamedView) -> None:
    """Register rigid bodies; their present poses and velocities are what additive and scaling start from."""
    get_registry().register_rigid(rigid_prim_view.name, [str(path) for path in rigid_prim_view.prim_paths])


def register_articulation_view(articulation_view: NamedView) -> None:
    """Register articulations, likewise.

    Raises:
        BadPrim: one has no joint between two bodies.
    """
    get_registry().register_robots(articulation_view.name, [str(path) for path in articulation_view.prim_paths])
