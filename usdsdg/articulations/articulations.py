"""The articulations of the current stage that scripts have asked for, which move with every physics step."""

from __future__ import annotations

from usdsdg.articulations.articulation import Articulation
from usdsdg.session import engines, stage_context
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline


class Articulations:
    """Articulations by the path of their prim."""

    def __init__(self) -> None:
        self._found: dict[str, Articulation] = {}
        stage_context.on_new_stage(lambda _stage: self._found.clear())
        engines.subscribe_step(self._step, before=True)
        get_timeline().subscribe(self._on_timeline)

    def at(self, root: str) -> Articulation:
        """Return the articulation of the prim at `root`; from now on physics steps move it.

        Raises:
            BadPrim: there is no joint between two bodies at or below it.
        """
        if root not in self._found:
            self._found[root] = Articulation(stage_context.current_stage(), root)
        return self._found[root]

    def restart(self) -> None:
        """Return all joints to where they were when the articulations were asked for."""
        for articulation in self._found.values():
            articulation.restart()

    def _step(self, dt: float) -> None:
        for articulation in list(self._found.values()):
            articulation.step(dt)

    def _on_timeline(self, event: str) -> None:
        if event == "stop":
            self.restart()


def get_articulations() -> Articulations:
    """Return the articulations of the session."""
    return current().articulations
