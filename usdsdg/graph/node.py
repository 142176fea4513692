"""A node of the randomization graph, and the handle to it that scripts hold."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from types import TracebackType
from typing import TYPE_CHECKING, Any

from pxr import Usd

from usdsdg.errors import GraphError, NotAPrim, UnknownInput, Unsupported, counted, warn_once
from usdsdg.graph.live_prims import LivePrims, joined
from usdsdg.graph.node_attributes import NodeAttribute, NodeType
from usdsdg.graph.node_prims import type_name
from usdsdg.graph.prim_path import PrimPath
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage

_FAMILIES = ("create", "get", "modify", "randomizer", "distribution", "trigger", "physics", "settings", "utils")
# The input of a group, as which Replicator's nodes hand on the prims that they have made or found.
PRIMS_IN = "primsIn"
_PACKAGE = str(Path(__file__).resolve().parents[1])


@contextmanager
def made_at(line: str) -> Iterator[None]:
    """Set the source line of nodes made in this block, in a file other than Python, such as "scene.yaml:12"."""
    lines = current().source_lines
    lines.append(line)
    try:
        yield
    finally:
        lines.pop()


def script_line() -> str:
    """Return the source line of new nodes, as in `my_script.py:41`: from `made_at`, or the nearest outside caller."""
    if lines := current().source_lines:
        return lines[-1]
    frame = sys._getframe(1)
    # "<string>" is the __init__ that dataclasses generate.
    while frame is not None and frame.f_code.co_filename.startswith((_PACKAGE, "<string>")):
        frame = frame.f_back
    if frame is None:
        return "<unknown>"
    name = Path(frame.f_code.co_filename).name
    # Bytes of a name that are no UTF-8 are half characters here, which the stage cannot hold.
    return f"{name.encode('utf-8', 'backslashreplace').decode()}:{frame.f_lineno}"


def rep_function() -> str:
    """Return the function of `rep` that a script has called, as in `create.cube`; "" where it is none of a family."""
    called, frame = "", sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith((_PACKAGE, "<string>")):
        family = frame.f_globals.get("__name__", "").removeprefix("usdsdg.").partition(".")[0]
        if family in _FAMILIES and not frame.f_code.co_name.startswith("_"):
            called = f"{family}.{frame.f_code.co_name}"
        frame = frame.f_back
    return called


@dataclass(eq=False)
class Node:
    """A node of the graph.

    `kind` is the name of its type in a saved graph (`OgnSampleUniform`), which determines its action (`graph.actions`).
    `inputs` holds plain values, or distributions that are sampled when this node runs. `prims` are the target paths, in
    order. `state` caches values of the action between executions.
    """

    kind: str
    inputs: dict[str, Any] = field(default_factory=dict)
    prims: tuple[str, ...] = ()
    name: str | None = None
    key: str = ""
    line: str = field(default_factory=script_line)
    function: str = field(default_factory=rep_function)
    executions: int = 0
    state: dict[str, Any] = field(default_factory=dict)
    path: str | None = None  # of its prim, on the stage with the root layer `layer`
    layer: Any = None
    is_off: bool = False  # a script has disabled it
    item: Any = field(default=None, init=False, repr=False)  # the first one made of it, such as a distribution

    def __post_init__(self) -> None:
        current().nodes.add(self)

    def get_attribute(self, name: str) -> NodeAttribute:
        """Return an input, with or without the `inputs:` prefix, or an output, to be read and set."""
        return NodeAttribute(self.item or ReplicatorItem(self), name if ":" in name else f"inputs:{name}")

    def get_attribute_exists(self, name: str) -> bool:
        """Whether the node has an input or output of that name."""
        try:
            self.get_attribute(name).get()
        except UnknownInput:
            return False
        return True

    def get_attributes(self) -> list[NodeAttribute]:
        """Return all inputs, then all outputs."""
        item = self.item or ReplicatorItem(self)
        names = [f"inputs:{name}" for name in item.inputs] + [f"outputs:{name}" for name in item.outputs]
        return [NodeAttribute(item, name) for name in names]

    def get_node_type(self) -> NodeType:
        """Return the type of the node, whose `get_node_type()` is what `get_type_name` returns."""
        return NodeType(self.get_type_name())

    def get_graph(self) -> Any:
        """Return the graph of the current stage."""
        return current().graph

    def is_valid(self) -> bool:
        """Whether the node is one of the current stage."""
        return self in current().nodes

    def set_disabled(self, disabled: bool) -> None:
        """Let the node not run from now on, or run again; what a disabled trigger executes does not run either."""
        self.is_off = bool(disabled)

    def is_disabled(self) -> bool:
        """Whether a script has disabled the node."""
        return self.is_off

    def get_type_name(self) -> str:
        """Return the type of the node, as `omni.replicator.core.OgnSampleUniform`."""
        return type_name(self.kind)

    def get_prim_path(self) -> str:
        """Return the path of the prim that holds the node.

        Raises:
            Unsupported: it has none, as it does not run in the graph: it created or found prims at once.
        """
        if self.path is None:
            raise Unsupported(
                f"{self.describe()} has no prim of its own, as it has run already; of an item `get_output_prims()` "
                "returns the prims"
            )
        return self.path

    def note_drawn(self, role: str, *, together: bool = False) -> None:
        """Note that an input was drawn for these prims, which are others in a copy for some of them.

        together: one row holds the values of all.
        """
        self.state.setdefault("drawn_for", {})[role] = (self.prims, together)

    def drawn_for(self, role: str) -> tuple[tuple[str, ...], bool]:
        """Return the prims for which an input was drawn last, and whether one row holds the values of all of them."""
        return self.state.get("drawn_for", {}).get(role, (self.prims, False))

    def describe(self) -> str:
        return f"{self.kind} (made at {self.line})"


def current_trigger() -> Any | None:
    """Return the trigger of the innermost `with trigger:`, or None."""
    triggers = current().open_triggers
    return triggers[-1] if triggers else None


def current_prims() -> tuple[str, ...]:
    """Return the prims of the innermost `with group:`, or ()."""
    groups = current().open_groups
    return groups[-1] if groups else ()


def why_no_prims(input_prims: Any) -> str:
    """Return why a node that was given `input_prims` has no prims to act on, and the remedy."""
    if input_prims is not None or current().open_groups:
        return "the item that it was given is empty. rep.get finds what is on the stage when its line runs"
    return "call it inside `with <group or prims>:` or pass input_prims"


class ReplicatorItem:
    """The result of a `rep` function: a node and the prims that it created or selected; a context manager.

    Mirrors `rep.utils.ReplicatorItem`.
    """

    def __init__(self, node: Node, *, trigger: Any | None = None) -> None:
        self.node = node
        self._trigger = trigger
        node.item = node.item or self

    @property
    def prims(self) -> tuple[str, ...]:
        """Paths of the prims that the node created, selects or acts on, in order."""
        prims = self.node.prims
        return prims.again() if isinstance(prims, LivePrims) else prims

    def get_output_prims(self) -> dict[str, list[Usd.Prim]]:
        """Return {"prims": prims}, invalid ones for paths that are not on the stage.

        The output prims of a node are those that it acts on; `prims` and `get_output("prims")` are their paths.
        """
        return {"prims": [current_stage().GetPrimAtPath(path) for path in self.prims]}

    get_input_prims = get_output_prims

    @property
    def inputs(self) -> list[str]:
        """The names of the node's inputs."""
        return list(self.get_inputs())

    @property
    def outputs(self) -> list[str]:
        """The names of the node's outputs."""
        return list(self.get_outputs())

    @property
    def executions(self) -> int:
        """How often the node, or the trigger, has run."""
        return self.node.executions if self._trigger is None else self._trigger.executions

    def get_inputs(self) -> dict[str, Any]:
        """Return the node's inputs by name, with the paths of the prims that it acts on."""
        takes_prims = current().graph.takes_prims(self.node)
        name = "prims" if takes_prims else PRIMS_IN if self._is_of_prims() else ""
        return {**self.node.inputs, **({name: list(map(PrimPath, self.prims))} if name else {})}

    def get_outputs(self) -> dict[str, Any]:
        """Return the outputs of the node by name: the paths of its prims, and how often it has run.

        The paths are texts which have also the methods of a USD path such as `GetString`.
        """
        return {"prims": list(map(PrimPath, self.prims)), "execCount": self.executions}

    def get_input(self, name: str) -> Any:
        """Return the input `name`, with or without the `inputs:` prefix; None for one that is not given.

        Raises:
            UnknownInput: (a ValueError and a KeyError) there is no such input; the message lists all inputs.
        """
        return _named(self.node, {**dict.fromkeys(self._known_inputs()), **self.get_inputs()}, name, "inputs:")

    def get_output(self, name: str) -> Any:
        """Return the output `name`, with or without the `outputs:` prefix.

        Raises:
            UnknownInput: (a ValueError and a KeyError) there is no such output; the message lists all outputs.
        """
        return _named(self.node, self.get_outputs(), name, "outputs:")

    def set_input(self, name: str, value: Any) -> None:
        """Change an input, with or without the `inputs:` prefix, from the next execution on.

        Unlike in Replicator the value may be a distribution, which is then drawn from, or an item, whose prims count.

        Raises:
            UnknownInput: (a ValueError and a KeyError) there is no such input; the message lists all inputs.
            NotAPrim: the value of `prims` is something else.
            GraphError: it is an input of a trigger, which cannot have the value.
        """
        name = name.removeprefix("inputs:")
        _named(self.node, dict.fromkeys(self._known_inputs()), name, "inputs:")
        if name in ("prims", PRIMS_IN):
            current().graph.retarget(self.node, prim_paths(value))
            return
        before = dict(self.node.inputs)
        self.node.inputs[name] = plain(value)
        try:
            current().graph.update_input(self.node, name)
        except GraphError:
            self.node.inputs = before
            raise

    def _is_of_prims(self) -> bool:
        """Return whether the item is what its node has made or found, which can be replaced by other prims."""
        return self._trigger is None and bool(self.node.prims)

    def _known_inputs(self) -> list[str]:
        return list(dict.fromkeys([*self.inputs, *current().graph.optional_inputs(self.node)]))

    def __enter__(self) -> ReplicatorItem:
        """Enter a block whose nodes run when this trigger fires, or act on these prims."""
        if self._trigger is not None:
            current().open_triggers.append(self._trigger)
        else:
            current().open_groups.append(self.prims)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Restore the trigger or prims of the enclosing block."""
        (current().open_groups if self._trigger is None else current().open_triggers).pop()

    def named_parts(self, consumer: str, execution: int, prims: Sequence[str]) -> dict[str, Any]:
        """Return draws of distributions with a name inside of this one, by name, one row per prim.

        None is the row of a prim for which `choice` or `sequence` took another one.
        """
        return {}

    def note_use(self, consumer: str, node: Node, trigger: Hashable) -> None:
        """Note that `node` takes its values under `trigger`, by the key `consumer`."""

    def rename_held(self, renamed: Callable[[Any], Any]) -> None:
        """Replace the values that the item keeps beside the inputs of its node by `renamed` of each."""

    @property
    def trigger(self) -> Any | None:
        """The trigger (`evaluate.Trigger`) that this is the item of, or None."""
        return self._trigger

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            message = f"{type(self).__name__!r} object has no attribute {name!r}"
            if hasattr(Usd.Prim, name):
                message += "; its prims, which have it, are in the list item.get_output_prims()['prims']"
            raise AttributeError(message, name=name, obj=self)

    def _repr_html_(self) -> str:
        from usdsdg.notebook.graphs import item_html

        return item_html(self)

    def __repr__(self) -> str:
        """Return the function that made it, as Replicator does, `omni.replicator.core.create.cube`."""
        if not self.node.function:
            return f"ReplicatorItem({self.node.kind}, {counted(len(self.prims), 'prim')})"
        return f"omni.replicator.core.{self.node.function}"


def _named(node: Node, values: dict[str, Any], name: str, prefix: str) -> Any:
    bare = name.removeprefix(prefix)
    if bare not in values:
        raise UnknownInput(f"{node.describe()} has no {prefix}{bare}; it has {', '.join(values) or 'none'}")
    return values[bare]


def item_of(value: Any) -> Any:
    """Return the item of a node, which scripts pass on as `item.node`, and other values as they are."""
    return (value.item or ReplicatorItem(value)) if isinstance(value, Node) else value


def prim_paths(items: Any) -> tuple[str, ...]:
    """Return the prim paths of an item or its node, a path, a prim, or a (nested) sequence of these, in order.

    Raises:
        NotAPrim: (a BadPrim and a TypeError) `items` is something else; the message shows it.
    """
    if items is None:
        return ()
    items = item_of(items)
    if isinstance(items, ReplicatorItem):
        return items.prims
    if isinstance(items, str):
        return (items,)
    if isinstance(items, os.PathLike):  # of an asset
        return (PurePath(items).as_posix(),)
    if hasattr(items, "GetPath"):
        return (str(items.GetPath()),)
    if type(items).__name__ == "Path" and hasattr(items, "pathString"):
        return (items.pathString,)
    if isinstance(items, Sequence):
        return joined([prim_paths(item) for item in items])
    raise NotAPrim(f"expected an item, prim, path or a list of these, got {type(items).__name__}: {items!r}")


def are_prims(values: Sequence[Any]) -> bool:
    """Return whether all values are paths of prims on the stage."""
    stage = current_stage()
    return all(isinstance(value, str) and value.startswith("/") and stage.GetPrimAtPath(value) for value in values)


def plain(value: Any) -> Any:
    """Return a value as a saved graph can hold it: items, prims and paths as path strings; distributions stay.

    An item of several prims becomes a list of their paths.
    """
    value = item_of(value)
    if isinstance(value, ReplicatorItem) and not hasattr(value, "sample"):
        if isinstance(value.prims, LivePrims):
            warn_once(
                "rep.get with cache_result=False: as an argument, such as surface_prims or look_at, it stands for the "
                "prims that its line finds; only `with` and input_prims search again at each execution."
            )
        return value.prims[0] if len(value.prims) == 1 else list(value.prims)
    if hasattr(value, "GetPath"):
        return str(value.GetPath())
    if type(value).__name__ == "Path" and hasattr(value, "pathString"):
        return value.pathString
    if isinstance(value, os.PathLike):
        return PurePath(value).as_posix()
    if isinstance(value, (list, tuple)):
        return type(value)(plain(each) for each in value)
    return value
