"""Single physics steps beside the timeline, as behaviors and grasping take them."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from usdsdg.articulations.articulations import get_articulations
from usdsdg.session import engines


def simulate(step_dt: float) -> None:
    """Take one step of `step_dt` seconds; the simulation starts if it is not running, and goes on until it is reset."""
    engine = engines.physics()
    engine.play()
    engine.step(step_dt)


def reset_simulation(*, restore: bool = True) -> None:
    """End the simulation; with `restore`, bodies return to where they were when it began."""
    if (engine := engines.physics_if_made()) is not None:
        engine.stop(restore=restore)
        if restore:
            get_articulations().restart()


def apply_forces(bodies: Sequence[str], forces: ArrayLike, positions: ArrayLike) -> None:
    """Push rigid bodies, by path, at world points [stage units] during the next step.

    Forces are in the stage's units of mass, length and s⁻².
    """
    engine = engines.physics()
    engine.play()
    engine.apply_forces(bodies, forces, positions=positions)
