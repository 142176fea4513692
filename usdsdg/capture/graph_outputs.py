"""Outputs of the graph in the payload of writers: execution counts of triggers and draws of named distributions."""

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.distribution import Distribution, draw
from usdsdg.graph.evaluate import graph


def trigger_outputs() -> dict[str, int]:
    """Return how often time triggers have fired, by name; writers number their sequences by it.

    Triggers with a name that another one has are `name_01` and so on.
    """
    found: dict[str, int] = {}
    for trigger in graph().triggers:
        if trigger.kind == "OgnOnTime":
            found[_free(trigger.name, found)] = trigger.executions
    return found


def _free(name: str, taken: Mapping[str, object]) -> str:
    numbered = (f"{name}_{number:02d}" for number in itertools.count(1))
    return name if name not in taken else next(each for each in numbered if each not in taken)


def distribution_outputs() -> dict[str, np.ndarray | list[Any]]:
    """Return the latest draw of each named distribution under a trigger, one row per prim of its consumer.

    Draws depend only on their keys, so they are repeated instead of being stored.
    """
    drawn: dict[str, np.ndarray | list[Any]] = {}
    for trigger in graph().triggers:
        for node in trigger.nodes:
            for role, value in node.inputs.items():
                if isinstance(value, Distribution) and value.node.name and node.executions:
                    rows = draw(value, node, node.executions - 1, role)
                    numeric = all(isinstance(row, (int, float, np.ndarray, np.generic)) for row in rows)
                    drawn[value.node.name] = np.array(rows) if numeric else rows
    return drawn
