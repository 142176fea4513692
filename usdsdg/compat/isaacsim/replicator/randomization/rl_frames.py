"""The trigger of domain randomization: frames of environments, counted by `step_randomization`, and their gates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from usdsdg.errors import ArgumentError
from usdsdg.graph import evaluate
from usdsdg.graph.evaluate import Trigger, graph
from usdsdg.graph.node import Node, ReplicatorItem, current_trigger

FRAME = "OgnOnRLFrame"
GATE = "OgnIntervalFiltering"


@dataclass(frozen=True)
class Selection:
    """The environments that a gate lets through, and whether they are being reset."""

    rows: Sequence[int]
    on_reset: bool


@dataclass(frozen=True)
class _Gate:
    trigger: Trigger
    select: Callable[[np.ndarray, np.ndarray], Selection]


class RlFrames:
    """Counts the frames of each environment since its last reset, and runs what is inside of the gates."""

    def __init__(self, environments: int) -> None:
        self.environments = environments
        self.counts: NDArray[np.int64] = np.zeros(environments, np.int64)
        self.reset_rows: NDArray[np.int64] = np.zeros(0, np.int64)
        self.selection: Selection | None = None  # of the gate whose nodes run now
        self._gates: list[_Gate] = []
        self._trigger = _never(FRAME, numEnvs=environments)
        self.item = graph().add_trigger(self._trigger)

    def add_interval(self, interval: int) -> ReplicatorItem:
        """Add a gate that lets an environment through at every `interval`-th frame after its reset."""

        def select(counts: np.ndarray, reset_rows: np.ndarray) -> Selection:
            return Selection(np.flatnonzero((counts > 0) & (counts % interval == 0)).tolist(), False)

        return self._add(_Gate(_never(GATE, interval=interval), select))

    def add_reset(self) -> ReplicatorItem:
        """Add a gate that lets environments through when they are reset."""

        def select(counts: np.ndarray, reset_rows: np.ndarray) -> Selection:
            return Selection(reset_rows.tolist(), True)

        return self._add(_Gate(_never(GATE, ignoreInterval=True), select))

    def step(self, reset_rows: Sequence[int] | np.ndarray) -> None:
        """Reset the counts of some environments, run the nodes of all gates that let any through, and count on."""
        self.reset_rows = np.asarray(reset_rows, np.int64).ravel()
        if len(self.reset_rows) and not 0 <= self.reset_rows.min() <= self.reset_rows.max() < self.environments:
            raise ArgumentError(f"step_randomization: {self.reset_rows.tolist()} is not within 0 and num_envs - 1")
        self.counts[self.reset_rows] = 0
        for node in self._trigger.nodes:
            evaluate.run(node)
        for gate in self._gates:
            selection = gate.select(self.counts, self.reset_rows)
            if selection.rows:
                self.selection = selection
                for node in gate.trigger.nodes:
                    evaluate.run(node)
        self.selection = None
        self.counts += 1

    def _add(self, gate: _Gate) -> ReplicatorItem:
        if current_trigger() is not self._trigger:
            raise ArgumentError("a gate must be made inside of `with trigger.on_rl_frame(...):`")
        self._gates.append(gate)
        return graph().add_trigger(gate.trigger)


def _never(kind: str, **inputs: int) -> Trigger:
    """Return a trigger that no frame of the orchestrator fires."""
    return Trigger(Node(kind, dict(inputs)), lambda _context: False, waits_for_frames=False)


def in_gate() -> bool:
    """Whether the innermost open block is a gate."""
    trigger = current_trigger()
    return trigger is not None and trigger.kind == GATE
