"""`SyntheticData`: which outputs of a render product are enabled, and their arrays.

There are no node graphs. A node template that exports the array of a render variable attaches our annotator of the same
array; any other template, and any change of connections, raises `Unsupported`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.annotator_registry import NodeConnectionTemplate
from usdsdg.compat.omni.graph.core import Graph, post_render_graph
from usdsdg.errors import Unsupported
from usdsdg.session.session import current
from usdsdg.session.stage_context import on_new_stage

# Annotator of each render variable.
RENDER_VARS: dict[str, str] = {
    "LdrColor": "rgb",
    "LdrColorSD": "rgb",
    "HdrColor": "HdrColor",
    "HdrColorSD": "HdrColor",
    "DepthSD": "distance_to_image_plane",
    "DepthLinearSD": "DepthLinearized",
    "DistanceToImagePlaneSD": "distance_to_image_plane",
    "DistanceToCameraSD": "distance_to_camera",
    "NormalSD": "normals",
    "TargetMotionSD": "motion_vectors",
    "CrossCorrespondenceSD": "cross_correspondence",
    "InstanceSegmentationSD": "instance_id_segmentation_fast",
    "SemanticSegmentationSD": "instance_id_segmentation_fast",
    "BoundingBox2DTightSD": "bounding_box_2d_tight_fast",
    "BoundingBox2DLooseSD": "bounding_box_2d_loose_fast",
    "BoundingBox3DSD": "instance_id_segmentation_fast",
    "OcclusionSD": "bounding_box_2d_loose_fast",
}
# Annotators that read labels, and see only those of type "class" here.
_OF_LABELS = ("bounding_box_2d_tight_fast", "bounding_box_2d_loose_fast")
# What is read with a function of `sensors`, which has more rows or fields than the annotator.
_TABLES = {"BoundingBox3DSD": "sensors.get_bounding_box_3d", "OcclusionSD": "sensors.get_occlusion"}
_EXPORT = ("ExportRawArray", "buffPtr", "Ptr", "")


class SyntheticDataException(Exception):
    """A sensor gave no data."""

    def __init__(self, message: str = "error") -> None:
        self.message = message
        super().__init__(message)


class SyntheticDataStage:
    """The stages of Omniverse's pipelines, in order."""

    AUTO = -1
    SIMULATION = 0
    PRE_RENDER = 1
    POST_RENDER = 2
    ON_DEMAND = 3


@dataclass
class NodeTemplate:
    """A node type with its connections and attributes."""

    pipeline_stage: int
    node_type_id: str
    connections: list[NodeConnectionTemplate] = field(default_factory=list)
    attributes: dict[str, Any] = field(default_factory=dict)


class SyntheticData:
    """The outputs that a script has enabled, by render product."""

    NodeConnectionTemplate = NodeConnectionTemplate
    NodeTemplate = NodeTemplate

    def __init__(self) -> None:
        self._annotators: dict[tuple[str, str], Annotator] = {}  # by render product and annotator name
        self._render_vars: set[tuple[str, str]] = set()
        on_new_stage(lambda _stage: self._forget())

    def _forget(self) -> None:
        """Forget the products of a stage, whose paths those of the next one have, too."""
        self._annotators.clear()
        self._render_vars.clear()

    @staticmethod
    def Get() -> SyntheticData:
        """Return the instance of the session."""
        return current().synthetic_data

    @staticmethod
    def Initialize() -> None:
        """Do nothing: the instance exists from the start."""

    @staticmethod
    def convert_sensor_type_to_rendervar(legacy_type_name: str) -> str:
        """Return the render variable of a sensor type, given by its name."""
        return {"Rgb": "LdrColorSD", "MotionVector": "TargetMotionSD"}.get(legacy_type_name, f"{legacy_type_name}SD")

    @staticmethod
    def disable_async_rendering() -> None:
        """Do nothing: rendering is synchronous."""

    @staticmethod
    def register_node_template(
        node_template: NodeTemplate, rendervars: Sequence[str] | None = None, template_name: str | None = None
    ) -> str:
        """Unsupported: there are no node graphs behind annotators.

        Raises:
            Unsupported: always; it names the node type.
        """
        raise Unsupported(
            f"SyntheticData.register_node_template: node type {node_template.node_type_id!r} has no counterpart. "
            "Register a Python function or a Warp kernel with rep.annotators.register_augmentation instead."
        )

    @staticmethod
    def is_node_template_registered(template_name: str) -> bool:
        """Return whether the template exports the array of a render variable."""
        return _render_var_of(template_name) in RENDER_VARS

    def enable_rendervar(self, render_product_path: str, render_var: str, usd_stage: object = None) -> None:
        """Enable a render variable; those that annotators read need not be enabled."""
        self._render_vars.add((str(render_product_path), render_var))

    def disable_rendervar(self, render_product_path: str, render_var: str, usd_stage: object = None) -> None:
        self._render_vars.discard((str(render_product_path), render_var))

    def is_rendervar_enabled(
        self, render_product_path: str, render_var: str, only_sdg_activated: bool = False, usd_stage: object = None
    ) -> bool:
        return (str(render_product_path), render_var) in self._render_vars or self.is_rendervar_used(
            render_product_path, render_var
        )

    def is_rendervar_used(self, render_product_path: str, render_var: str) -> bool:
        """Return whether a template exports the render variable."""
        return self._exporter(render_product_path, render_var) is not None

    def activate_node_template(
        self,
        template_name: str,
        render_product_path_index: int = -1,
        render_product_paths: Sequence[str] | None = None,
        attributes: Mapping[str, Any] | None = None,
        stage: object = None,
        activate_render_vars: bool = True,
    ) -> None:
        """Enable the array that the template exports, from the next update on.

        Raises:
            Unsupported: the template does not export the array of a render variable that we have.
            BadPrim: there is no such render product.
        """
        name = _annotator_of(template_name)
        for path in map(str, render_product_paths or ()):
            known = self._annotators.get((path, name))
            if known is None or known.render_product != path:
                params = {"semanticFilter": "class:*"} if name in _OF_LABELS else None
                self._annotators[path, name] = named_annotators.get(name, params).attach(path)

    def is_node_template_activated(
        self, template_name: str, render_product_path: str | None = None, only_manually_activated: bool = False
    ) -> bool:
        return self._exporter(render_product_path or "", _render_var_of(template_name)) is not None

    def deactivate_node_template(
        self,
        template_name: str,
        render_product_path_index: int = -1,
        render_product_paths: Sequence[str] = (),
        stage: object = None,
        deactivate_render_vars: bool = False,
        recurse_only_automatically_activated: bool = True,
    ) -> None:
        """Disable what `activate_node_template` has enabled."""
        for path in map(str, render_product_paths):
            annotator = self._annotators.pop((path, _annotator_of(template_name)), None)
            if annotator is not None:
                annotator.detach()

    def get_node_attributes(
        self,
        template_name: str,
        attribute_names: Sequence[str],
        render_product_path: str | None = None,
        gpu: bool = False,
    ) -> dict[str, Any] | None:
        """Return "outputs:data" (bytes, uint8), "outputs:width", "outputs:height" and "outputs:bufferSize".

        None if the template is not activated.

        Raises:
            Unsupported: the array is a table that a function of `sensors` builds.
        """
        render_var = _render_var_of(template_name)
        if render_var in _TABLES:
            raise Unsupported(f"SyntheticData: {render_var} has no array of its own; use {_TABLES[render_var]}")
        array = self.read(render_var, render_product_path or "")
        if array is None:
            return None
        height, width = array.shape[:2] if array.ndim > 1 else (0, 0)
        data = np.ascontiguousarray(array).view(np.uint8).reshape(-1)
        outputs = {"data": data, "width": width, "height": height, "bufferSize": data.nbytes}
        wanted = (name.removeprefix("outputs:") for name in attribute_names)
        return {f"outputs:{name}": outputs[name] for name in wanted if name in outputs}

    def set_instance_mapping_semantic_filter(self, predicate: str = "*:*") -> None:
        """Select the labels that annotators without a filter of their own read; "*:*" selects all.

        Writers that were initialized before with neither types nor a predicate read them as well.
        """
        current().label_filter = None if predicate in ("", "*", "*:*") else predicate
        current().label_filter_sets += 1

    def get_instance_mapping_semantic_filter(self) -> str:
        return current().label_filter or "*:*"

    def set_default_semantic_filter(
        self, predicate: str = "*:*", hierarchical_labels: bool = False, matching_labels: bool = True
    ) -> None:
        """As `set_instance_mapping_semantic_filter`; the two switches are ignored: their defaults apply."""
        self.set_instance_mapping_semantic_filter(predicate)

    def get_default_semantic_filter(self) -> str:
        return self.get_instance_mapping_semantic_filter()

    def get_graph(self, stage: int = SyntheticDataStage.ON_DEMAND, renderProductPath: str | None = None) -> Graph:
        """Return the graph to which nodes of a camera's signal processing can be added.

        Raises:
            Unsupported: another stage than POST_RENDER, or no render product.
        """
        if stage != SyntheticDataStage.POST_RENDER or not renderProductPath:
            raise Unsupported(
                "SyntheticData.get_graph: only the POST_RENDER graph of a render product takes nodes; annotators and "
                "augmentations do the work of the other graphs."
            )
        return post_render_graph(str(renderProductPath))

    def read(self, render_var: str, render_product_path: str) -> np.ndarray | None:
        """Return the array of an enabled render variable; None if it is not enabled or there is no frame yet."""
        annotator = self._exporter(render_product_path, render_var)
        if annotator is None:
            return None
        got = annotator.get_data()
        array = got["data"] if isinstance(got, dict) else got
        return array if array.size or annotator.has_data else None

    def annotation(self, render_var: str, render_product_path: str) -> tuple[np.ndarray, dict[str, Any]] | None:
        """Return the array of an enabled render variable with the tables of its annotator; None as `read`."""
        annotator = self._exporter(render_product_path, render_var)
        if annotator is None or self.read(render_var, render_product_path) is None:
            return None
        got = annotator.get_data()
        return (got["data"], got["info"]) if isinstance(got, dict) else (got, {})

    def _exporter(self, render_product_path: str, render_var: str) -> Annotator | None:
        annotator = self._annotators.get((str(render_product_path), RENDER_VARS.get(render_var, "")))
        return annotator if annotator is not None and annotator.is_attached else None


def _render_var_of(template_name: str) -> str:
    """Return the render variable that the template exports, or the name itself."""
    bare = (template_name.removesuffix(suffix) for suffix in _EXPORT)
    return next((name for name in bare if name in RENDER_VARS), template_name)


def _annotator_of(template_name: str) -> str:
    render_var = _render_var_of(template_name)
    if render_var not in RENDER_VARS:
        raise Unsupported(
            f"SyntheticData: the node template {template_name!r} has no counterpart. These export arrays, as NAME or "
            f"NAMEExportRawArray: {', '.join(RENDER_VARS)}."
        )
    return RENDER_VARS[render_var]
