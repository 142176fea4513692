"""The graph of a stage and its evaluation: triggers, and the nodes that they execute.

The order of execution: triggers in the order in which the script made them; under a trigger, its nodes in source order.
Nodes outside any trigger run once, before all triggers, at the next evaluation or when the timeline begins to play.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from usdsdg.errors import GraphError, UsdsdgError, let_pass
from usdsdg.graph.actions import action_of, optional_inputs
from usdsdg.graph.authoring import author, author_impulse, author_input, author_prims
from usdsdg.graph.edited_inputs import EditedInputs, adopt_input
from usdsdg.graph.live_prims import LivePrims
from usdsdg.graph.node import Node, ReplicatorItem, current_prims, current_trigger, plain, prim_paths, why_no_prims
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.scopes import PIPELINE


def _accept(_node: Node) -> None:
    """Take any inputs."""


@dataclass(eq=False)
class Trigger:
    """A trigger and its nodes, which run when `due` returns true.

    `due` is called once per evaluation, and once more for each further queued event. `blocked` returns why the trigger
    cannot fire in the current state, or "". `prepare` is called before the nodes, but not at a preview. If
    `counts_previews` is false, previews do not count as executions. `check` raises if an input of the node, which
    scripts can set, has a value that it cannot have.
    """

    node: Node
    due: Callable[[TriggerContext], bool]
    nodes: list[Node] = field(default_factory=list)
    executions: int = 0
    previews: int = 0  # how many of the executions were previews
    latest: int = 0  # the number of the capture for which it has fired last, 0 for a preview
    blocked: Callable[[], str] = str
    prepare: Callable[[], None] | None = None
    counts_previews: bool = True
    waits_for_frames: bool = True  # False: a script's own call runs its nodes
    counted_from: int = 0  # executions of earlier runs, which `max_execs` does not count
    check: Callable[[Node], None] = _accept

    @property
    def max_execs(self) -> int:
        """How often it fires at most; 0: no limit."""
        return int(self.node.inputs.get("maxExecs", 0))

    @property
    def rt_subframes(self) -> int:
        """The minimum number of sub-frames of the captures that it fires for."""
        return int(self.node.inputs.get("rtSubframes", 1))

    @property
    def kind(self) -> str:
        """The type of its node."""
        return self.node.kind

    @property
    def name(self) -> str:
        """The name in keys, payloads and messages."""
        return self.node.name or self.node.kind

    @property
    def firings(self) -> int:
        """How often it has fired, previews left out."""
        return self.executions - self.previews

    @property
    def exhausted(self) -> bool:
        return 0 < self.max_execs <= self.executions - self.counted_from


@dataclass(frozen=True)
class TriggerContext:
    """The state that a trigger's `due` depends on."""

    capture: int  # number of earlier captures; -1 outside a capture
    time: float  # of the timeline [s], without wrapping at loops
    events: frozenset[str]
    preview: bool = False


def puts_bodies_back(fired: list[Trigger]) -> bool:
    """Return whether a trigger that fired has reset physics: the picture shows bodies where its nodes have put them."""
    return any(trigger.prepare is not None for trigger in fired)


class Graph:
    """All nodes of the current stage."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Remove all nodes, as for a new stage; their prims stay."""
        self.triggers: list[Trigger] = []
        self.impulses: list[Node] = []
        self.drawn_once: dict[str, list[Any]] = {}  # by name, the draws of named distributions outside triggers
        # By path, where projector and targets were when a projection was computed; None: not looked for yet.
        self.projections: dict[str, Any] | None = None
        self.edits = EditedInputs()
        self._events: list[str] = []
        self._keys: Counter[str] = Counter()

    def add(self, node: Node) -> Node:
        """Add a node under the current trigger, or as one that runs once if there is none."""
        trigger = current_trigger()
        self._give_key(node, trigger.name if trigger else "once")
        nodes = trigger.nodes if trigger else self.impulses
        starter = trigger.node.path if trigger else author_impulse()
        author(node, after=nodes[-1].path if nodes else starter)
        nodes.append(node)
        _note_uses(node, trigger)
        return node

    def add_trigger(self, trigger: Trigger) -> ReplicatorItem:
        self.triggers.append(trigger)
        author(trigger.node, after=None)
        return ReplicatorItem(trigger.node, trigger=trigger)

    def adopt(self, node: Node, trigger: Trigger | None) -> None:
        """Add a node of a saved graph, which has its key and its prim already."""
        (trigger.nodes if trigger else self.impulses).append(node)
        _note_uses(node, trigger)
        base, _, number = node.key.rpartition("#")
        self._keys[base] = max(self._keys[base], int(number) + 1 if number.isdigit() else 0)

    def adopt_trigger(self, trigger: Trigger) -> None:
        """Add a trigger of a saved graph."""
        self.triggers.append(trigger)

    def _give_key(self, node: Node, trigger: str) -> None:
        # The key depends on what the node does, not on when it was made, so that adding or removing other nodes does
        # not change it. Nodes with the same trigger, kind, attribute and targets are numbered. A name replaces these.
        targets = [node.prims.text()] if isinstance(node.prims, LivePrims) else node.prims
        about = node.name or "|".join([node.kind, str(node.inputs.get("attribute", "")), *targets])
        node.key = self.next_key(f"{trigger}/{about}")

    def next_key(self, base: str) -> str:
        """Return `base` with a number that no other key with it has."""
        key = f"{base}#{self._keys[base]}"
        self._keys[base] += 1
        return key

    def update_input(self, node: Node, name: str) -> None:
        """Author the changed input of a node.

        Raises:
            GraphError: the node is a trigger's, which cannot have the value.
        """
        for trigger in self.triggers:
            if node is trigger.node:
                trigger.check(node)
        author_input(node, name)
        for trigger in self.triggers:
            if node in trigger.nodes:
                _note_uses(node, trigger)

    def retarget(self, node: Node, prims: tuple[str, ...]) -> None:
        """Set and author the target prims of a node, which it acts on from its next execution on."""
        node.prims = prims
        # The state belongs to the former prims.
        node.state.clear()
        author_prims(node)

    def get_nodes(self) -> list[Node]:
        """Return the nodes that have a prim, in the order of these: triggers, distributions, and what they run."""
        layer = current_stage().GetRootLayer()
        nodes = {node.path: node for node in current().nodes if node.path is not None and node.layer == layer}
        children = current_stage().GetPrimAtPath(PIPELINE)
        paths = [str(child.GetPath()) for child in children.GetChildren()] if children else []
        return [nodes[path] for path in paths if path in nodes]

    def get_node(self, path: str) -> Node | None:
        """Return the node whose prim is at `path`, which may be its name alone; None if there is none."""
        wanted = path if path.startswith("/") else f"{PIPELINE}/{path}"
        return next((node for node in self.get_nodes() if node.path == wanted), None)

    def get_path_to_graph(self) -> str:
        """Return the path of the prim that the nodes' prims are below."""
        return PIPELINE

    def is_valid(self) -> bool:
        """Whether the stage has the graph's prim."""
        return bool(current_stage().GetPrimAtPath(PIPELINE))

    def takes_prims(self, node: Node) -> bool:
        """Return whether target prims are an input of a node, and not just what it has made or found."""
        return action_of(node.kind) is not None

    def optional_inputs(self, node: Node) -> tuple[str, ...]:
        """Return the inputs that a node may have or lack."""
        return optional_inputs(node.kind)

    def send(self, event: str) -> None:
        """Queue a custom event for the next evaluation."""
        self._events.append(event)

    def evaluate(self, *, capture: int = -1, time: float = 0.0, preview: bool = False) -> list[Trigger]:
        """Run pending nodes and the triggers that are due; return the triggers that fired.

        A custom event sent twice fires twice. `preview` runs every frame and time trigger once, as the orchestrator's
        initialization does.
        """
        self.adopt_edits()
        self.run_impulses()
        if preview:
            # Custom events are not previewed: they stay queued for the next evaluation.
            return self._fire(TriggerContext(capture, time, frozenset(), preview))
        events, self._events = self._events, []
        fired = self._fire(TriggerContext(capture, time, frozenset(events[:1])))
        for event in events[1:]:
            fired += self._fire(TriggerContext(-1, time, frozenset([event])))
        return fired

    def adopt_edits(self) -> None:
        """Give nodes the inputs that a script has edited at their prims."""
        for path in self.edits.take():
            node = self.get_node(str(path.GetPrimPath()))
            if node is not None and node.get_attribute_exists(path.name):
                adopt_input(node, path)

    def run_impulses(self) -> None:
        """Run the nodes that run once and have not run yet."""
        impulses, self.impulses = self.impulses, []
        for node in impulses:
            run(node)
            for role, value in node.inputs.items():
                if isinstance(value, ReplicatorItem) and "samples" in value.node.state:
                    if value.node.name:
                        self.drawn_once[value.node.name] = list(value.node.state["samples"])
                    consumer, (prims, _) = f"{node.key}/{value.node.name or role}", node.drawn_for(role)
                    parts = value.named_parts(consumer, node.executions - 1, prims)
                    self.drawn_once |= {name: list(rows) for name, rows in parts.items()}

    def _fire(self, context: TriggerContext) -> list[Trigger]:
        active = [trigger for trigger in self.triggers if not (trigger.exhausted or trigger.node.is_off)]
        due = [trigger for trigger in active if trigger.due(context)]
        for trigger in due:
            if trigger.prepare is not None and not context.preview:
                trigger.prepare()
            for node in trigger.nodes:
                run(node)
            if trigger.counts_previews or not context.preview:
                trigger.executions += 1
                trigger.previews += context.preview
                trigger.latest = max(trigger.latest, context.capture)
        return due

    def _repr_html_(self) -> str:
        from usdsdg.notebook.graphs import graph_html

        return graph_html(self)

    def restart(self) -> None:
        """Reset draws and execution counts, as when a stopped orchestrator starts."""
        for trigger in self.triggers:
            trigger.executions = trigger.previews = trigger.counted_from = trigger.latest = 0
        self.restart_draws()

    def renew_limits(self) -> None:
        """Let every trigger fire `max_execs` times again."""
        for trigger in self.triggers:
            trigger.counted_from = trigger.executions

    def restart_draws(self) -> None:
        """Reset the execution counts of nodes, so that they repeat their first draws."""
        for trigger in self.triggers:
            for node in trigger.nodes:
                node.executions = 0


def _note_uses(node: Node, trigger: Trigger | None) -> None:
    """Tell the distributions among the inputs of a node under a trigger that it draws from them."""
    # Objects that are made once, as in a loop, draw on their own: else all would be in one place.
    for role, value in node.inputs.items() if trigger is not None else ():
        if isinstance(value, ReplicatorItem):
            value.note_use(f"{node.key}/{value.node.name or role}", node, trigger)


def run(node: Node) -> None:
    """Execute one node; errors name the script line that made it."""
    action = action_of(node.kind)
    if action is None or node.is_off:
        return
    if isinstance(node.prims, LivePrims) and (found := node.prims.again(node.executions)) != node.prims:
        graph().retarget(node, found)
    if isinstance(node.prims, LivePrims) and not node.prims:
        node.executions += 1
        return
    try:
        action(node, node.executions)
    except UsdsdgError as error:
        raise GraphError(f"{node.describe()}: {error}") from error
    except (TypeError, ValueError, RuntimeError, KeyError) as error:
        raise GraphError(f"{node.describe()} failed: {type(error).__name__}: {error}") from error
    node.executions += 1


def graph() -> Graph:
    """Return the graph of the current stage."""
    return current().graph


def act_now(kind: str, input_prims: Any = None, **inputs: Any) -> ReplicatorItem:
    """Execute an action with constant inputs at once; inside a trigger, add it as a node instead.

    Raises:
        GraphError: no prims are given or enclose it. An item of none, as of count=0, is acted on as such.
    """
    if current_trigger() is not None:
        return act(kind, input_prims, **inputs)
    given = {role: plain(value) for role, value in inputs.items() if value is not None}
    node = Node(kind=kind, inputs=given, prims=_targets(input_prims), key="now")
    if not node.prims and input_prims is None:
        let_pass(GraphError(f"{node.describe()} has no prims to act on: {why_no_prims(input_prims)}."))
    elif action := action_of(kind):
        action(node, 0)
    return ReplicatorItem(node)


def act(kind: str, input_prims: Any = None, name: str | None = None, **inputs: Any) -> ReplicatorItem:
    """Add an action node on `input_prims` (default: the enclosing `with group:`); inputs that are None are left out.

    Raises:
        GraphError: there are no prims to act on.
    """
    prims = _targets(input_prims)
    given = {role: plain(value) for role, value in inputs.items() if value is not None}
    node = Node(kind=kind, inputs=given, prims=prims, name=name)
    if not prims and not isinstance(prims, LivePrims):
        let_pass(GraphError(f"{node.describe()} has no prims to act on: {why_no_prims(input_prims)}."))
        return ReplicatorItem(node)
    return ReplicatorItem(graph().add(node))


def _targets(input_prims: Any) -> tuple[str, ...]:
    given = prim_paths(input_prims)
    # What a search finds may be nothing now, and something later.
    return given if given or isinstance(given, LivePrims) else current_prims()
