"""The registered views of the session, and the values that additive and scaling randomization start from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from usdsdg.compat.isaacsim.replicator.randomization.gravity import SceneGravity
from usdsdg.compat.isaacsim.replicator.randomization.rigid_bodies import RigidBodies
from usdsdg.compat.isaacsim.replicator.randomization.rl_frames import RlFrames
from usdsdg.compat.isaacsim.replicator.randomization.robots import Robots
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.session import stage_context
from usdsdg.session.session import current

Array = NDArray[np.float64]


class Values(Protocol):
    """Rows of numbers that can be read and written by attribute."""

    paths: tuple[str, ...]

    def read(self, attribute: str) -> Array: ...

    def write(self, attribute: str, rows: Sequence[int], values: Array) -> None: ...


@dataclass
class RegisteredView:
    """A view with its values at the registration, and those of the latest reset."""

    values: Values
    initial: dict[str, Array] = field(default_factory=dict)
    reset: dict[str, Array] = field(default_factory=dict)

    def remember(self, attribute: str) -> None:
        """Keep the present values of an attribute, unless they are kept already."""
        if attribute not in self.initial:
            self.initial[attribute] = self.values.read(attribute)
            self.reset[attribute] = self.initial[attribute].copy()

    def base(self, table: dict[str, Array], attribute: str, rows: Sequence[int]) -> Array:
        """Return the values of some rows to start from.

        Raises:
            Unsupported: nobody has authored one of them, so that it is not known.
        """
        found = table[attribute][list(rows)]
        unknown = np.flatnonzero(np.isnan(found).any(axis=1))
        if len(unknown):
            raise Unsupported(
                f"{self.values.paths[rows[unknown[0]]]}: {attribute} is not authored, so nothing can be added to it or "
                'multiplied with it; author it, or use operation="direct"'
            )
        return found


class Registry:
    """Views by kind and name, and the trigger that steps them; all of the current stage."""

    def __init__(self) -> None:
        self.clear()
        stage_context.on_new_stage(lambda _stage: self.clear())

    def clear(self) -> None:
        """Forget all views and the trigger."""
        self.scene: RegisteredView | None = None
        self.rigid: dict[str, RegisteredView] = {}
        self.robots: dict[str, RegisteredView] = {}
        self.frames: RlFrames | None = None

    def register_scene(self) -> None:
        self.scene = RegisteredView(SceneGravity())
        self.scene.remember("gravity")

    def register_rigid(self, name: str, paths: Sequence[str]) -> None:
        view = self.rigid[name] = RegisteredView(RigidBodies(paths))
        for attribute in ("position", "orientation", "linear_velocity", "angular_velocity", "velocity"):
            view.remember(attribute)

    def register_robots(self, name: str, paths: Sequence[str]) -> None:
        view = self.robots[name] = RegisteredView(Robots(paths))
        for attribute in Robots.SUPPORTED:
            view.remember(attribute)

    def view(self, kind: str, name: str) -> RegisteredView:
        """Return a registered view of a kind: "scene", "rigid" or "robots".

        Raises:
            ArgumentError: (a ValueError) there is none of that name.
        """
        if kind == "scene":
            if self.scene is None:
                raise ArgumentError("no simulation context is registered; call register_simulation_context first")
            return self.scene
        views = self.rigid if kind == "rigid" else self.robots
        if name not in views:
            known = ", ".join(views) or "none"
            what = "rigid prim view" if kind == "rigid" else "articulation view"
            raise ArgumentError(f"there is no registered {what} {name!r}; registered: {known}")
        return views[name]

    def running(self) -> RlFrames:
        """Return the trigger.

        Raises:
            ArgumentError: there is none.
        """
        if self.frames is None:
            raise ArgumentError("nothing is to be randomized; make a trigger with trigger.on_rl_frame first")
        return self.frames


def get_registry() -> Registry:
    """Return the registry of the session."""
    return current().domain_randomization
