"""A stand-in for ROS and its graph nodes: annotators of render products, published on topics within the process."""

import importlib.util
import itertools
import json
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

# Annotators of the helper's types of messages.
ANNOTATORS = {
    "rgb": "rgb", "bbox_2d_tight": "bounding_box_2d_tight", "bbox_2d_loose": "bounding_box_2d_loose",
    "bbox_3d": "bounding_box_3d", "instance_segmentation": "instance_segmentation",
    "semantic_segmentation": "semantic_segmentation",
}  # fmt: skip
HELPER, CLOCK = "isaacsim.ros2.bridge.ROS2CameraHelper", "isaacsim.ros2.bridge.ROS2PublishClock"
PRODUCT, VIEWPORT = "isaacsim.core.nodes.IsaacCreateRenderProduct", "isaacsim.core.nodes.IsaacGetViewportRenderProduct"
QUEUED = 10  # messages that a subscription keeps


# --- topics ---


class Subscription:
    """Messages of a topic that its callback has not received yet."""

    def __init__(self, topic: str, callback: Callable) -> None:
        self.topic, self.callback = topic.strip("/"), callback
        self.waiting: deque = deque(maxlen=QUEUED)


class RosNode:
    """A node with subscriptions."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.subscriptions: list[Subscription] = []
        _nodes.append(self)

    def create_subscription(self, kind: type, topic: str, callback: Callable, qos: object, **_: Any) -> Subscription:
        self.subscriptions.append(Subscription(topic, callback))
        return self.subscriptions[-1]

    def destroy_subscription(self, subscription: Subscription) -> None:
        self.subscriptions.remove(subscription)

    def count_publishers(self, topic: str) -> int:
        return int(topic.strip("/") in _published)

    def destroy_node(self) -> None:
        _nodes.remove(self)


_nodes: list[RosNode] = []
_published: set[str] = set()


def publish(topic: str, message: Any) -> None:
    """Queue a message for all subscriptions of a topic."""
    _published.add(topic.strip("/"))
    for subscription in itertools.chain.from_iterable(node.subscriptions for node in _nodes):
        if subscription.topic == topic.strip("/"):
            subscription.waiting.append(message)


def spin_once(node: RosNode, timeout_sec: float = 0.0) -> None:
    """Deliver the oldest message of each subscription of a node."""
    for subscription in list(node.subscriptions):
        if subscription.waiting:
            subscription.callback(subscription.waiting.popleft())


# --- graphs ---


class Graph:
    """Nodes that publish at every update while the timeline plays."""

    def __init__(self, path: str) -> None:
        import omni.usd

        self.path, self.stage = path, omni.usd.get_context().get_stage()
        self.kinds: dict[str, str] = {}
        self.inputs: dict[str, dict[str, Any]] = {}
        self.sources: dict[tuple[str, str], str] = {}  # (node, input) -> node
        self._products: dict[str, Any] = {}
        self._annotators: dict[str, Any] = {}

    def edit(self, commands: Mapping[str, Any]) -> None:
        for name, kind in commands.get("create_nodes", ()):
            self.kinds[name], self.inputs[name] = kind, {}
        for path, value in commands.get("set_values", ()):
            self.set(path, value)
        for source, target in commands.get("connect", ()):
            node, _, attribute = target.partition(".inputs:")
            self.sources[node, attribute] = source.partition(".")[0]

    def set(self, path: str, value: Any) -> None:
        node, _, attribute = path.partition(".inputs:")
        self.inputs[node][attribute] = value

    def publish(self) -> None:
        """Publish what all nodes have to say about the stage as it is."""
        import omni.timeline

        seconds = omni.timeline.get_timeline_interface().get_current_time()
        for name, kind in self.kinds.items():
            if kind == CLOCK:
                publish("clock", SimpleNamespace(clock=_stamp(seconds)))
            elif kind == HELPER:
                self._publish_annotator(name, self.inputs[name], seconds)

    def _publish_annotator(self, name: str, inputs: Mapping[str, Any], seconds: float) -> None:
        import omni.replicator.core as rep

        if name not in self._annotators:
            annotator = rep.annotators.get(ANNOTATORS[inputs["type"]])
            self._annotators[name] = annotator.attach(self._product_of(name))
        seen = self._annotators[name].get_data()
        if not len(seen):  # nothing was rendered since it was attached
            return
        stamp = _stamp(time.time() if inputs.get("useSystemTime") else seconds)
        if not isinstance(seen, dict):
            seen = {"data": seen, "info": {}}
        publish(inputs["topicName"], _message(inputs["type"], seen["data"], stamp))
        if inputs.get("enableSemanticLabels"):
            told = {str(key): value for key, value in seen["info"]["idToLabels"].items()}
            text = json.dumps({**told, "time_stamp": {"sec": stamp.sec, "nanosec": stamp.nanosec}})
            publish(inputs["semanticLabelsTopicName"], SimpleNamespace(data=text))

    def _product_of(self, node: str) -> str:
        import omni.kit.viewport.utility
        import omni.replicator.core as rep

        source = self.sources.get((node, "renderProductPath"))
        if source is None:
            return self.inputs[node]["renderProductPath"]
        if self.kinds[source] == VIEWPORT:
            return omni.kit.viewport.utility.get_active_viewport().get_render_product_path()
        if source not in self._products:
            given = self.inputs[source]
            size = given["width"], given["height"]
            self._products[source] = rep.create.render_product(str(given["cameraPrim"][0]), size, force_new=True)
        return self._products[source].path


_graphs: dict[str, Graph] = {}


def _edit(graph: Mapping[str, Any], commands: Mapping[str, Any]) -> None:
    """Stand in for `Controller.edit`: a graph of that path replaces an earlier one."""
    path = graph["graph_path"]
    _graphs[path] = Graph(path)
    _graphs[path].edit(commands)


class _GraphAttribute:
    def __init__(self, path: str) -> None:
        node, _, attribute = path.partition(".inputs:")
        graph, _, self._node = node.rpartition("/")
        self._graph, self._attribute = _graphs[graph], attribute

    def set(self, value: Any) -> None:
        self._graph.inputs[self._node][self._attribute] = value


def _on_update(_: object) -> None:
    import omni.timeline
    import omni.usd

    stage = omni.usd.get_context().get_stage()
    for path in [path for path, graph in _graphs.items() if graph.stage is not stage]:
        del _graphs[path]  # graphs are prims of their stage
    if omni.timeline.get_timeline_interface().is_playing():
        for graph in _graphs.values():
            graph.publish()


# --- messages ---


def _stamp(seconds: float) -> SimpleNamespace:
    return SimpleNamespace(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))


def _message(kind: str, data: np.ndarray, stamp: SimpleNamespace) -> SimpleNamespace:
    header = SimpleNamespace(stamp=stamp)
    if kind.startswith("bbox_2d"):
        return SimpleNamespace(header=header, detections=[_detection(row, _box_2d(row)) for row in data])
    if kind == "bbox_3d":
        return SimpleNamespace(header=header, detections=[_detection(row, _box_3d(row)) for row in data])
    return SimpleNamespace(header=header, data=data, height=data.shape[0], width=data.shape[1])


def _detection(row: np.void, box: SimpleNamespace) -> SimpleNamespace:
    hypothesis = SimpleNamespace(class_id=str(row["semanticId"]), score=1.0)
    return SimpleNamespace(bbox=box, results=[SimpleNamespace(hypothesis=hypothesis)])


def _box_2d(row: np.void) -> SimpleNamespace:
    x0, y0, x1, y1 = (float(row[name]) for name in ("x_min", "y_min", "x_max", "y_max"))
    center = SimpleNamespace(position=SimpleNamespace(x=(x0 + x1) / 2, y=(y0 + y1) / 2), theta=0.0)
    return SimpleNamespace(center=center, size_x=x1 - x0, size_y=y1 - y0)


def _box_3d(row: np.void) -> SimpleNamespace:
    """Return the center in the world, and the size with the scale of the transform applied."""
    low, high = (np.array([row[f"{axis}_{end}"] for axis in "xyz"], float) for end in ("min", "max"))
    transform = row["transform"].astype(float)
    center = np.append((low + high) / 2, 1.0) @ transform
    size = (high - low) * np.linalg.norm(transform[:3, :3], axis=1)
    position, lengths = (SimpleNamespace(x=v[0], y=v[1], z=v[2]) for v in (center, size))
    return SimpleNamespace(center=SimpleNamespace(position=position), size=lengths)


# --- modules ---


def install(file: Path) -> None:
    """Make the modules of ROS importable, and the one that a file of tests imports from beside itself."""
    import omni.graph.core
    import omni.kit.app

    _module("rclpy", ok=lambda: True, init=lambda: None, shutdown=lambda: None, create_node=RosNode,
            spin_once=spin_once)  # fmt: skip
    names = {
        "sensor_msgs.msg": ("Image",), "std_msgs.msg": ("String",), "rosgraph_msgs.msg": ("Clock",),
        "vision_msgs.msg": ("Detection2DArray", "Detection3DArray"),
    }  # fmt: skip
    for name, messages in names.items():
        _module(name.partition(".")[0])
        _module(name, **{each: SimpleNamespace for each in messages})
    _module("isaac_tests", __path__=[])
    _module("isaac_tests.common", get_qos_profile=lambda: QUEUED)
    for name in ("isaacsim.ros2", "isaacsim.ros2.core", "isaacsim.ros2.core.impl"):
        _module(name, __path__=[])
    _module("isaacsim.test.utils.image_io", save_rgb_image=lambda *_: None)
    _module("isaacsim.ros2.core.impl.ros2_image_test_utils", ros2_image_to_buffer=lambda image, **_: image.data)
    base = file.parents[3] / "isaacsim.ros2.core/python/impl/ros2_test_case.py"
    if base.is_file():
        spec = importlib.util.spec_from_file_location("isaacsim.ros2.core.impl.ros2_test_case", base)
        assert spec is not None
        assert spec.loader is not None
        module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    omni.graph.core.Controller.edit = staticmethod(_edit)
    omni.graph.core.Controller.attribute = staticmethod(_GraphAttribute)
    stream = omni.kit.app.get_app().get_update_event_stream()
    _subscription.append(stream.create_subscription_to_pop(_on_update))


_subscription: list[Any] = []  # keeps it alive


def _module(name: str, **attributes: Any) -> ModuleType:
    module = ModuleType(name)
    vars(module).update(attributes)
    sys.modules[name] = module
    return module
