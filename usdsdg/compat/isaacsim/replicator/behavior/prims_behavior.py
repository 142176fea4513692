"""What the randomizers share: the prims that they act on, their random numbers, and undoing it all on stop."""

from __future__ import annotations

import logging
from typing import ClassVar

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, BaseBehavior, Variable, variable
from usdsdg.graph.sampling import generator, get_global_seed

_log = logging.getLogger("usdsdg.script")

INCLUDE_CHILDREN = variable(
    "includeChildren", Sdf.ValueTypeNames.Bool, True, "Also act on the prims below, where the behavior applies to them."
)
SEED = variable("seed", Sdf.ValueTypeNames.Int, -1, "Seed of the random numbers; -1 derives one from the global seed.")


class PrimsBehavior(BaseBehavior):
    """Acts on its prim and, with `includeChildren`, on those below; restores them when the timeline stops.

    Variables are read when the timeline begins to play, also after a pause; what the prims were like is kept from the
    first play to the stop.
    """

    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [INCLUDE_CHILDREN, INTERVAL]

    def on_init(self) -> None:
        self._valid_prims: list[Usd.Prim] = []
        super().on_init()

    def on_destroy(self) -> None:
        self._reset()
        super().on_destroy()

    def on_play(self) -> None:
        super().on_play()
        self._read_variables()
        if not self._valid_prims:
            self._begin()
        # With an interval of 0 the first update comes at once.
        if self._interval > 0:
            self._apply_behavior()

    def on_stop(self) -> None:
        self._reset()
        super().on_stop()

    # --- what a behavior defines ---
    def _applies_to(self, prim: Usd.Prim) -> bool:
        return prim.IsA(UsdGeom.Xformable)

    def _read_variables(self) -> None:
        """Read the behavior's own variables."""

    def _remember(self, prim: Usd.Prim) -> None:
        """Keep what the behavior is about to change of a prim."""

    def _restore(self, prim: Usd.Prim) -> None:
        """Undo what the behavior has changed of a prim, which still exists."""

    # --- from play to stop ---
    def _begin(self) -> None:
        candidates = Usd.PrimRange(self.prim) if self._get_exposed_variable("includeChildren") else [self.prim]
        self._valid_prims = [prim for prim in candidates if self._applies_to(prim)]
        if not self._valid_prims:
            _log.warning("[%s] %s has no prim to act on", self.prim_path, type(self).__name__)
        for prim in self._valid_prims:
            self._remember(prim)

    def _reset(self) -> None:
        for prim in self._valid_prims:
            if prim:
                self._restore(prim)
        self._valid_prims = []

    def _prim_at(self, path: str) -> Usd.Prim | None:
        """Return the xformable prim at a path; None if the path is empty or, with a warning, names none."""
        if not path:
            return None
        prim = self.stage.GetPrimAtPath(path)
        if prim and prim.IsA(UsdGeom.Xformable):
            return prim
        _log.warning("[%s] %s: there is no xformable prim %s", self.prim_path, type(self).__name__, path)
        return None


class RandomBehavior(PrimsBehavior):
    """A `PrimsBehavior` with random numbers, which begin anew at every play after a stop."""

    def on_init(self) -> None:
        self._own_rng: np.random.Generator | None = None
        super().on_init()

    @property
    def _rng(self) -> np.random.Generator:
        if self._own_rng is None:
            seed = self._get_exposed_variable("seed")
            self._own_rng = seeded_generator(-1 if seed is None else seed, f"{self.BEHAVIOR_NS}|{self.prim_path}")
        return self._own_rng

    def set_rng(self, rng: np.random.Generator | None = None) -> None:
        """Replace the random numbers, until the timeline stops; None: by some that differ in every process."""
        self._own_rng = np.random.default_rng() if rng is None else rng

    def _reset(self) -> None:
        super()._reset()
        self._own_rng = None


def seeded_generator(seed: int, key: str) -> np.random.Generator:
    """Return a NumPy generator: of a seed >= 0, as `numpy.random.default_rng` makes it, else of the global seed."""
    return np.random.default_rng(seed) if seed >= 0 else generator(get_global_seed(), key, 0)
