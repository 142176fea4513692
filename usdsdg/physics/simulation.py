"""Simulate and reset without a timeline. Mirrors `rep.physics.simulate` and `reset`."""

from typing import Any

from usdsdg.errors import GraphError
from usdsdg.functional import physics
from usdsdg.graph.actions import action, action_of
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import Node, ReplicatorItem, current_trigger, prim_paths


def simulate(time: float, step_dt: float | None = None, physics_scene: Any = None) -> ReplicatorItem:
    """Simulate the rigid bodies for `time` seconds without the timeline: at once, or when the enclosing trigger fires.

    Args:
        step_dt: length of a step [s]; by default that of the PhysicsScene.
        physics_scene: the first PhysicsScene of the stage, which is the one that is simulated.

    Raises:
        PhysicsError: `time` or `step_dt` is not positive, or no whole number of steps makes a second.
        Unsupported: `physics_scene` is another one.
    """
    return _now_or_later("OgnSimulate", time=time, stepDt=step_dt, physicsScene=_scene_path(physics_scene))


@action("OgnSimulate", "stepDt", "physicsScene")
def _simulate(node: Node, execution: int) -> None:
    physics.simulate(node.inputs["time"], node.inputs.get("stepDt"), node.inputs.get("physicsScene"))


def simulate_until_rest(prims: Any = None, max_time: float = 10.0) -> list[str] | ReplicatorItem:
    """Move bodies that overlap apart, then simulate until they rest: at once, or when the enclosing trigger fires.

    Replicator has nothing like it; see `functional.physics.simulate_until_rest`.

    Args:
        prims: the rigid bodies to wait for; None: all.
        max_time: simulated seconds after which it ends in any case.

    Returns:
        At once: the paths of the bodies that still move. Inside a trigger: a node, which warns of them.
    """
    if current_trigger() is None:
        return physics.simulate_until_rest(None if prims is None else prim_paths(prims), max_time)
    return _now_or_later("OgnSimulateUntilRest", bodies=None if prims is None else prim_paths(prims), maxTime=max_time)


@action("OgnSimulateUntilRest", "bodies")
def _simulate_until_rest(node: Node, execution: int) -> None:
    physics.simulate_until_rest(node.inputs.get("bodies"), node.inputs["maxTime"])


def reset(physics_scene: Any = None) -> ReplicatorItem:
    """Restore the poses and velocities from when the timeline began to play: at once, or when the trigger fires."""
    return _now_or_later("OgnResetPhysics", physicsScene=_scene_path(physics_scene))


@action("OgnResetPhysics")
def _reset(node: Node, execution: int) -> None:
    physics.reset()


def _scene_path(physics_scene: Any) -> str | None:
    """Return the path of the one PhysicsScene given; None for None."""
    paths = prim_paths(physics_scene)
    if len(paths) > 1:
        raise GraphError(f"physics_scene is {len(paths)} prims; give one PhysicsScene")
    return paths[0] if paths else None


def _now_or_later(kind: str, **inputs: Any) -> ReplicatorItem:
    """Execute a node without prims at once, or add it to the enclosing trigger."""
    node = Node(kind=kind, inputs={name: value for name, value in inputs.items() if value is not None})
    if current_trigger() is not None:
        return ReplicatorItem(graph().add(node))
    if do := action_of(kind):
        do(node, 0)
    return ReplicatorItem(node)
