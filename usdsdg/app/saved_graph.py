"""Save and load the graph of a stage with its run: seed, settings, number of frames, writers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pxr import Sdf, Usd

from usdsdg import distribution, trigger
from usdsdg.create.render_products import HydraTexture, products
from usdsdg.errors import GraphError, warn_once
from usdsdg.graph import evaluate
from usdsdg.graph.actions import action_of, load_actions
from usdsdg.graph.live_prims import from_text
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.graph.node_prims import Link, NodeRecord, define_node, read_node
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session.settings.store import get_settings, lets_files_run_code
from usdsdg.stage.scopes import PIPELINE
from usdsdg.writers.base import ON_FRAME, Writer, attached_writers, trigger_of

WRITERS = "/WriterOrchestrator"
_SETTINGS = "renderSettings"


@dataclass
class SavedRun:
    """The run that a saved stage records: seed, frames, settings and writers."""

    seed: int
    frames: int
    rt_subframes: int
    settings: dict[str, Any]
    writers: list[SavedWriter] = field(default_factory=list)


@dataclass
class SavedWriter:
    name: str
    arguments: dict[str, Any]
    # path -> camera and resolution, or cameras and resolution of each tile
    products: dict[str, tuple[str | list[str], tuple[int, int]]]
    trigger: str = ""  # path of the trigger's node; "" for every frame


# --- to the stage ---


def author_run(stage: Usd.Stage, *, frames: int, rt_subframes: int) -> None:
    """Author the seed, changed settings, number of captures, and attached writers with their render products."""
    root = stage.GetPrimAtPath(PIPELINE)
    if not root:
        return
    metadata = {"usdsdg:globalSeed": get_global_seed(), "usdsdg:frames": frames, "usdsdg:rtSubframes": rt_subframes}
    for name, value in metadata.items():
        root.CreateAttribute(name, Sdf.ValueTypeNames.Int64).Set(int(value))
    data = stage.GetRootLayer().customLayerData
    data[_SETTINGS] = {key.lstrip("/").replace("/", ":"): value for key, value in _plain_settings().items()}
    stage.GetRootLayer().customLayerData = data
    stage.RemovePrim(WRITERS)
    for writer in attached_writers():
        _author_writer(stage, writer)


def _plain_settings() -> dict[str, Any]:
    """Return the changed settings that USD can hold, without the seed, which is authored on the graph."""
    changed = get_settings().changed()
    return {
        k: v for k, v in changed.items() if isinstance(v, (bool, int, float, str)) and not k.endswith("/globalSeed")
    }


def _author_writer(stage: Usd.Stage, writer: Writer) -> None:
    known = {product.path: product for product in products()}
    attached = [known[path] for path in writer.render_products if path in known]
    rows = [[product.path, *_cameras_and_size(product)] for product in attached]
    inputs = {"writerName": type(writer).__name__, "parameters": writer.parameters, "renderProducts": rows}
    inputs |= {"trigger": path} if (path := _path_of_trigger(writer)) else {}
    if not stage.GetPrimAtPath(WRITERS):
        stage.DefinePrim(WRITERS, "OmniGraph")
    path = f"{WRITERS}/{type(writer).__name__}_{len(stage.GetPrimAtPath(WRITERS).GetChildren())}"
    try:
        define_node(stage, path, NodeRecord("OgnScheduleWriter", inputs))
    except TypeError as error:
        stage.RemovePrim(path)
        warn_once(f"the saved stage does not say how to make its writer: {error}. Give its arguments as plain values.")


def _path_of_trigger(writer: Writer) -> str:
    """Return the path of the node that decides at which frames a writer is due; "" for every frame."""
    chosen = trigger_of(writer)
    if chosen == ON_FRAME:
        return ""
    node = getattr(chosen, "node", None)
    if node is None or node.path is None:
        what = "a Python function" if callable(chosen) else "schedule_write()"
        warn_once(
            f"the saved stage does not hold when its {type(writer).__name__} is due, which {what} decides: it will "
            "write every frame. Attach it with what trigger.on_frame or another trigger returns."
        )
        return ""
    return node.path


def _cameras_and_size(product: HydraTexture) -> tuple[str | list[str], list[int]]:
    if product.tiles is not None:
        return list(product.tiles.cameras), list(product.tiles.size)
    return product.camera_path, list(product.resolution)


# --- from the stage ---


def load(stage: Usd.Stage) -> SavedRun:
    """Build the current graph from the nodes on `stage`, and return the run that it records.

    Raises:
        GraphError: the stage holds no graph, or one that needs Python code; the message names the node.
    """
    root = stage.GetPrimAtPath(PIPELINE)
    if not root:
        raise GraphError(
            f"the stage has no {PIPELINE}, the graph that scripts leave in the stages that they save. `usdsdg render` "
            "makes a still of a stage without one."
        )
    load_actions()
    evaluate.graph().reset()
    _Loader(stage).load(root)
    return _read_run(stage, root)


def warn_of_idle_triggers(stage: Usd.Stage) -> None:
    """Warn of triggers that a stage was saved with, which fire where the graph is loaded and not in scripts."""
    root = stage.GetPrimAtPath(PIPELINE)
    running = {each.node.path for each in evaluate.graph().triggers}
    prims = [prim for prim in root.GetChildren() if str(prim.GetPath()) not in running] if root else []
    for prim in prims:
        record = read_node(prim)
        if record.kind != "OnImpulseEvent" and record.after is None and _is_trigger(record):
            warn_once(
                f"{prim.GetPath()} is a trigger of the graph that the stage was saved with, and does not fire in this "
                "run. `usdsdg generate FILE` runs the graph of a stage; a script makes its own with rep.trigger."
            )


class _Loader:
    """Builds the graph from node prims in stage order, in which the script made them."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._distributions: dict[str, ReplicatorItem] = {}
        self._trigger_of: dict[
            str, evaluate.Trigger | None
        ] = {}  # by path of the trigger's node and of the nodes under it

    def load(self, root: Usd.Prim) -> None:
        graph = evaluate.graph()
        for prim in root.GetChildren():
            path, record = str(prim.GetPath()), read_node(prim)
            if record.kind == "OnImpulseEvent":
                self._trigger_of[path] = None
            elif record.after is not None:
                node = self._node(path, record)
                self._trigger_of[path] = starter = self._starter(path, record)
                graph.adopt(node, starter)
            elif _is_trigger(record):
                self._trigger_of[path] = starter = trigger.trigger_of(self._node(path, record))
                graph.adopt_trigger(starter)

    def _starter(self, path: str, record: NodeRecord) -> evaluate.Trigger | None:
        if record.after not in self._trigger_of:
            raise GraphError(f"{path} is started by {record.after}, which is not before it in the graph")
        if action_of(record.kind) is None:
            raise GraphError(f"{path} is of type {record.kind}, which this version does not know")
        return self._trigger_of[record.after]

    def _node(self, path: str, record: NodeRecord) -> Node:
        inputs = {name: self._value(value) for name, value in record.inputs.items()}
        metadata = record.metadata
        name, key, line = metadata.get("name"), metadata.get("key", ""), metadata.get("line", path)
        prims = from_text(metadata["search"]) if "search" in metadata else record.prims
        node = Node(record.kind, inputs, prims, name, key, line)
        node.path, node.layer = path, self._stage.GetRootLayer()
        return node

    def _value(self, value: Any) -> Any:
        if isinstance(value, Link):
            return self._distribution(value.path)
        if isinstance(value, list):
            return [self._value(each) for each in value]
        return value

    def _distribution(self, path: str) -> ReplicatorItem:
        if path not in self._distributions:
            prim = self._stage.GetPrimAtPath(path)
            if not prim:
                raise GraphError(f"{path}, which a node of the graph draws from, is not on the stage")
            record = read_node(prim)
            inputs = {name: self._value(value) for name, value in record.inputs.items()}
            try:
                item = distribution.from_inputs(record.kind, inputs, record.metadata.get("name"))
            except GraphError as error:
                raise GraphError(f"{path}: {error}. Save the stage again.") from None
            item.node.path, item.node.layer = path, self._stage.GetRootLayer()
            item.node.line = record.metadata.get("line", path)
            self._distributions[path] = item
        return self._distributions[path]


def _is_trigger(record: NodeRecord) -> bool:
    return record.kind.startswith(("OgnOn", "On")) or record.kind == "OgnConditionScript"


def _read_run(stage: Usd.Stage, root: Usd.Prim) -> SavedRun:
    def number(name: str) -> int:
        try:
            return int(root.GetAttribute(f"usdsdg:{name}").Get() or 0)
        except (TypeError, ValueError):
            raise GraphError(f"{root.GetPath()}.usdsdg:{name} is no number; save the stage again") from None

    stored = stage.GetRootLayer().customLayerData.get(_SETTINGS, {})
    if not isinstance(stored, dict):
        raise GraphError(f"customLayerData {_SETTINGS!r} of the stage has no settings in it; save the stage again")
    settings = {"/" + key.replace(":", "/"): value for key, value in stored.items()}
    settings = {key: value for key, value in settings.items() if not lets_files_run_code(key)}
    run = SavedRun(number("globalSeed"), number("frames"), number("rtSubframes"), settings)
    holder = stage.GetPrimAtPath(WRITERS)
    for prim in holder.GetChildren() if holder else ():
        run.writers.append(_read_writer(prim))
    return run


def _read_writer(prim: Usd.Prim) -> SavedWriter:
    inputs = read_node(prim).inputs
    try:
        attached = {path: (camera, (int(size[0]), int(size[1]))) for path, camera, size in inputs["renderProducts"]}
        return SavedWriter(inputs["writerName"], dict(inputs["parameters"]), attached, str(inputs.get("trigger", "")))
    except (KeyError, IndexError, TypeError, ValueError) as error:
        message = f"{prim.GetPath()} is no writer as usdsdg saves them ({error!r}); save the stage again"
        raise GraphError(message) from error
