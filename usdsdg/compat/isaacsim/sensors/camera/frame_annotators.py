"""Annotators of a `Camera`: what its frames have, by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.errors import warn_once

# Annotators of the `add_..._to_frame` functions, by their names there.
_FRAME_ANNOTATORS = {
    "bounding_box_2d_tight": "bounding_box_2d_tight_fast",
    "bounding_box_2d_loose": "bounding_box_2d_loose_fast",
    "instance_id_segmentation": "instance_id_segmentation_fast",
    "instance_segmentation": "instance_segmentation_fast",
}
# Keys of Isaac Sim 4 and earlier, which frames have beside those of today.
_EARLIER_KEYS = {"rgb": "rgba"}


class FrameAnnotators:
    """Attaches annotators to the camera's render product, and adds their data to its frames."""

    prim_path: str
    _render_product_path: str | None
    _annotator_device: str | None
    _custom_annotators: dict[str, Annotator]
    _current_frame: dict[str, Any]
    _resolution: tuple[int, int]

    @property
    def supported_annotators(self) -> list[str]:
        """Annotators that an `add_..._to_frame` function attaches; `attach_annotator` takes any."""
        return [
            "normals", "motion_vectors", "occlusion", "distance_to_image_plane", "distance_to_camera",
            "bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "semantic_segmentation",
            "instance_id_segmentation", "instance_segmentation", "pointcloud",
        ]  # fmt: skip

    def attach_annotator(self, annotator_name: str, **kwargs: Any) -> None:
        """Add the data of an annotator, with these init parameters, to the frame; "_fast" is left out of its key.

        Raises:
            RuntimeError: `initialize` has not been called.
            AnnotatorRegistryError: there is no such annotator.
        """
        if not self._render_product_path:
            raise RuntimeError(f"Camera {self.prim_path}: call initialize() before annotators are attached")
        key = annotator_name.replace("_fast", "")
        if key in self._custom_annotators:
            warn_once(f"Camera {self.prim_path}: annotator {key} is attached already")
            return
        annotator = named_annotators.get(annotator_name, kwargs, device=self._annotator_device)
        self._custom_annotators[key] = annotator.attach(self._render_product_path)
        self._current_frame |= dict.fromkeys(_keys(key))
        if key == "rgb":  # scripts that read it before anything was rendered make a picture of it
            width, height = self._resolution
            self._current_frame["rgba"] = np.zeros((height, width, 4), np.uint8)

    def detach_annotator(self, annotator_name: str) -> None:
        """Take an annotator out of the frame."""
        key = annotator_name.replace("_fast", "")
        annotator = self._custom_annotators.pop(key, None)
        if annotator is None:
            warn_once(f"Camera {self.prim_path}: annotator {key} is not attached")
            return
        annotator.detach()
        for each in _keys(key):
            self._current_frame.pop(each)

    def _data(self) -> dict[str, Any]:
        """Return the data of all annotators by the keys of frames."""
        data = {name: annotator.get_data() for name, annotator in self._custom_annotators.items()}
        return {key: value for name, value in data.items() for key in _keys(name)}

    def _add(self, name: str, init_params: Mapping[str, Any] | None) -> None:
        self.attach_annotator(_FRAME_ANNOTATORS.get(name, name), **(init_params or {}))

    def add_rgb_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("rgb", init_params)

    def remove_rgb_from_frame(self) -> None:
        self.detach_annotator("rgb")

    def add_normals_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("normals", init_params)

    def remove_normals_from_frame(self) -> None:
        self.detach_annotator("normals")

    def add_motion_vectors_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("motion_vectors", init_params)

    def remove_motion_vectors_from_frame(self) -> None:
        self.detach_annotator("motion_vectors")

    def add_occlusion_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("occlusion", init_params)

    def remove_occlusion_from_frame(self) -> None:
        self.detach_annotator("occlusion")

    def add_distance_to_image_plane_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("distance_to_image_plane", init_params)

    def remove_distance_to_image_plane_from_frame(self) -> None:
        self.detach_annotator("distance_to_image_plane")

    def add_distance_to_camera_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("distance_to_camera", init_params)

    def remove_distance_to_camera_from_frame(self) -> None:
        self.detach_annotator("distance_to_camera")

    def add_bounding_box_2d_tight_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("bounding_box_2d_tight", init_params)

    def remove_bounding_box_2d_tight_from_frame(self) -> None:
        self.detach_annotator("bounding_box_2d_tight")

    def add_bounding_box_2d_loose_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("bounding_box_2d_loose", init_params)

    def remove_bounding_box_2d_loose_from_frame(self) -> None:
        self.detach_annotator("bounding_box_2d_loose")

    def add_bounding_box_3d_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("bounding_box_3d", init_params)

    def remove_bounding_box_3d_from_frame(self) -> None:
        self.detach_annotator("bounding_box_3d")

    def add_semantic_segmentation_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("semantic_segmentation", init_params)

    def remove_semantic_segmentation_from_frame(self) -> None:
        self.detach_annotator("semantic_segmentation")

    def add_instance_id_segmentation_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("instance_id_segmentation", init_params)

    def remove_instance_id_segmentation_from_frame(self) -> None:
        self.detach_annotator("instance_id_segmentation")

    def add_instance_segmentation_to_frame(self, init_params: dict[str, Any] | None = None) -> None:
        self._add("instance_segmentation", init_params)

    def remove_instance_segmentation_from_frame(self) -> None:
        self.detach_annotator("instance_segmentation")

    def add_pointcloud_to_frame(
        self, include_unlabelled: bool = True, init_params: dict[str, Any] | None = None
    ) -> None:
        self._add("pointcloud", {"includeUnlabelled": include_unlabelled, **(init_params or {})})

    def remove_pointcloud_from_frame(self) -> None:
        self.detach_annotator("pointcloud")


def _keys(name: str) -> list[str]:
    """Return the keys of frames under which the data of an annotator are."""
    return [name, _EARLIER_KEYS[name]] if name in _EARLIER_KEYS else [name]
