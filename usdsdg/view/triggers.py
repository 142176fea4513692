"""The triggers of the graph, run once more with another seed."""

from __future__ import annotations

from usdsdg.graph import evaluate
from usdsdg.session.session import current


def names() -> list[str]:
    """Return the names of the triggers that have something to run."""
    return [trigger.name for trigger in evaluate.graph().triggers if trigger.nodes]


def run_again(seed: int) -> None:
    """Run the nodes of every trigger once, also of those that wait for events, with the draws of another seed.

    The seed and the counts of executions are put back, so that a script which goes on draws what it would have drawn.

    Raises:
        GraphError: a node failed; the message names the script line that made it.
    """
    global_seed = current().global_seed
    nodes = [node for trigger in evaluate.graph().triggers for node in trigger.nodes]
    before, executions = global_seed.value, [node.executions for node in nodes]
    try:
        # Not by the setting, whose change restarts the generators of a script that goes on.
        global_seed.value = seed
        for node in nodes:
            node.executions = 0
            evaluate.run(node)
    finally:
        global_seed.value = before
        for node, count in zip(nodes, executions, strict=True):
            node.executions = count
