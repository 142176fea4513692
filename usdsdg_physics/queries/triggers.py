"""Which colliders are inside triggers, and which enter and leave."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from usdsdg.stage.physics.instances import whole
from usdsdg_physics.queries.scene_queries import SceneQueries
from usdsdg_physics.scene.events import TriggerEvent
from usdsdg_physics.scene.records import STATIC, Scene

Pair = tuple[str, str]  # trigger, other collider


class Triggers:
    """The triggers of one scene.

    A trigger reports every collider that overlaps it and is neither a trigger, nor of the same body, nor, where the
    trigger is static, static itself; pairs that are filtered from colliding are not reported.
    """

    def __init__(self, scene: Scene, queries: SceneQueries) -> None:
        self._scene, self._queries = scene, queries
        self.paths = [path for path, collider in scene.colliders.items() if collider.trigger]

    def inside(self, poses: np.ndarray) -> list[Pair]:
        """Return the pairs of a trigger and a collider inside it, for the poses (N, 7) of the bodies."""
        pairs = [pair for pair in self._queries.overlapping_pairs(poses, self.paths) if self._reports(*pair)]
        return list(dict.fromkeys((whole(trigger), whole(other)) for trigger, other in pairs))

    def events(self, before: Collection[Pair], after: Collection[Pair]) -> list[TriggerEvent]:
        """Return what left and what entered between two sets of pairs."""
        left = [self._event(pair, entered=False) for pair in before if pair not in after]
        return left + [self._event(pair, entered=True) for pair in after if pair not in before]

    def _reports(self, trigger: str, other: str) -> bool:
        first, second = self._scene.colliders[trigger], self._scene.colliders[other]
        both_static = first.body == STATIC and second.body == STATIC
        return not second.trigger and not both_static and tuple(sorted((trigger, other))) not in self._scene.filtered

    def _event(self, pair: Pair, *, entered: bool) -> TriggerEvent:
        trigger, other = pair
        return TriggerEvent(entered, trigger, self._body(trigger), other, self._body(other))

    def _body(self, path: str) -> str:
        collider = self._scene.colliders.get(path)  # None of one that was removed
        return (collider.body if collider else "") or path
