"""Outputs of the graph in the payload of writers: execution counts of triggers and draws of named distributions."""

import itertools
from collections.abc import Mapping
from typing import Any, TypedDict

import numpy as np

from usdsdg.distribution import Distribution, named_draws
from usdsdg.graph.evaluate import graph

# Types of triggers that have a name of their own; conditions and custom events are in no payload.
_NAMED_TRIGGERS = ("OgnOnFrame", "OgnOnTime")


class GraphOutputs(TypedDict):
    """What a payload tells of the graph."""

    trigger_outputs: dict[str, int]
    distribution_outputs: dict[str, Any]
    named_outputs: dict[str, dict[str, Any]]


def graph_outputs() -> GraphOutputs:
    """Return the three entries of a payload that tell of the graph, by key.

    "trigger_outputs" has how often each trigger has fired, "distribution_outputs" the latest draw of each named
    distribution, and "named_outputs" both, as {"execCounts": count} and {"samples": draw}.
    """
    counts, draws = trigger_outputs(), distribution_outputs()
    named: dict[str, dict[str, Any]] = {name: {"execCounts": count} for name, count in counts.items()}
    for name, rows in draws.items():
        named[name] = {**named.get(name, {}), "samples": rows}
    return {"trigger_outputs": counts, "distribution_outputs": draws, "named_outputs": named}


def trigger_outputs() -> dict[str, int]:
    """Return how often triggers of frames and of time have fired, previews left out, by name.

    Triggers with a name that another one has are `name_01` and so on. Writers number their sequences by triggers with
    "on_time" in their names.
    """
    found: dict[str, int] = {}
    for trigger in graph().triggers:
        if trigger.kind in _NAMED_TRIGGERS:
            found[_free(trigger.name, found)] = trigger.firings
    return found


def _free(name: str, taken: Mapping[str, object]) -> str:
    numbered = (f"{name}_{number:02d}" for number in itertools.count(1))
    return name if name not in taken else next(each for each in numbered if each not in taken)


def distribution_outputs() -> dict[str, np.ndarray | list[Any]]:
    """Return the latest draw of each named distribution, one row per prim of its consumer.

    `combine`, `choice` or `sequence` may hold it; the row of a prim for which these took another one is None.
    """
    drawn = {name: _rows(rows) for name, rows in graph().drawn_once.items()}
    for trigger in graph().triggers:
        for node in trigger.nodes:
            for role, value in node.inputs.items():
                if isinstance(value, Distribution) and node.executions and value.names():
                    drawn |= {name: _rows(list(rows)) for name, rows in named_draws(value, node, role).items()}
    return drawn


def _rows(rows: list[Any]) -> np.ndarray | list[Any]:
    numeric = all(isinstance(row, (int, float, np.ndarray, np.generic)) for row in rows)
    return np.array(rows) if numeric else rows
