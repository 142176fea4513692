"""`omni.isaac.synthetic_utils`: `SyntheticDataHelper`, the sensors of a viewport by the names of Isaac Sim 2021."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.app.app import get_app
from usdsdg.compat.omni.syntheticdata import helpers, sensors
from usdsdg.compat.omni.syntheticdata._syntheticdata import SensorType
from usdsdg.errors import ArgumentError
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.poses.transforms import local_to_world

__all__ = ["SyntheticDataHelper"]

_SENSORS: Mapping[str, tuple[SensorType, Callable[..., Any]]] = {
    "rgb": (SensorType.Rgb, sensors.get_rgb),
    "depth": (SensorType.DistanceToImagePlane, sensors.get_distance_to_image_plane),
    "depthLinear": (SensorType.DistanceToCamera, sensors.get_distance_to_camera),
    "instanceSegmentation": (SensorType.InstanceSegmentation, sensors.get_instance_segmentation),
    "semanticSegmentation": (SensorType.SemanticSegmentation, sensors.get_semantic_segmentation),
    "boundingBox2DTight": (SensorType.BoundingBox2DTight, sensors.get_bounding_box_2d_tight),
    "boundingBox2DLoose": (SensorType.BoundingBox2DLoose, sensors.get_bounding_box_2d_loose),
    "boundingBox3D": (SensorType.BoundingBox3D, sensors.get_bounding_box_3d),
    "occlusion": (SensorType.Occlusion, sensors.get_occlusion),
    "motion-vector": (SensorType.MotionVector, sensors.get_motion_vector),
    "normals": (SensorType.Normal, sensors.get_normals),
}
_OPTIONS = {
    "instanceSegmentation": {"parsed": True, "return_mapping": True},
    "boundingBox3D": {"parsed": True, "return_corners": True},
}


class SyntheticDataHelper:
    """Reads sensors of a viewport."""

    def initialize(self, sensor_names: Iterable[str], viewport: Any) -> None:
        """Turn sensors on, and update the application so that they have data.

        Raises:
            ArgumentError: there is no such sensor.
        """
        self._enable(sensor_names, viewport)
        get_app().update()

    async def initialize_async(self, sensor_names: Iterable[str], viewport: Any) -> None:
        """As `initialize`, and wait for the update."""
        self._enable(sensor_names, viewport)
        await sensors.next_sensor_data_async(viewport)

    def get_groundtruth(
        self,
        sensor_names: Sequence[str],
        viewport: Any,
        verify_sensor_init: bool = True,
        wait_for_sensor_data: float = 0.1,
    ) -> dict[str, Any]:
        """Return the data of sensors by name, and "state", whether each has some.

        Args:
            sensor_names: "rgb", "depth" along the optical axis, "depthLinear", "instanceSegmentation" and its table,
                "semanticSegmentation", "boundingBox2DTight", "boundingBox2DLoose", "boundingBox3D" with corners,
                "occlusion", "motion-vector", "normals", "camera" and "pose".
            verify_sensor_init: turn the sensors on first, and update the application where no event loop runs.
            wait_for_sensor_data: ignored: data is complete.

        Raises:
            ArgumentError: there is no such sensor.
        """
        if verify_sensor_init:
            if asyncio._get_running_loop() is None:
                self.initialize(sensor_names, viewport)
            else:
                self._enable(sensor_names, viewport)
        found: dict[str, Any] = {}
        for name in sensor_names:
            if name == "camera":
                found[name] = self.get_camera_params(viewport)
            elif name == "pose":
                found[name] = self.get_pose()
            else:
                found[name] = _known(name)[1](viewport, **_OPTIONS.get(name, {}))
        return {**found, "state": dict.fromkeys(sensor_names, True)}

    def get_camera_params(self, viewport: Any) -> dict[str, Any]:
        """Return pose (4, 4) in the world for row vectors, fov [rad], lens, matrix to clip space, and resolution."""
        view = helpers.get_view_params(viewport)
        prim = current_stage().GetPrimAtPath(str(viewport.get_active_camera()))
        return {
            "pose": np.array(local_to_world(prim, stage_time(current_stage()))),
            "fov": 2 * math.atan(view["horizontal_aperture"] / (2 * view["focal_length"])),
            "focal_length": view["focal_length"],
            "horizontal_aperture": view["horizontal_aperture"],
            "view_projection_matrix": helpers.get_view_proj_mat(view),
            "resolution": {"width": view["width"], "height": view["height"]},
            "clipping_range": view["clipping_range"],
        }

    def get_pose(self) -> list[tuple[str, int, str, np.ndarray]]:
        """Return path, semantic id, label and pose (4, 4) in the world for row vectors of each labeled prim."""
        stage = current_stage()
        return [
            (
                str(row["name"]),
                int(row["semanticId"]),
                str(row["semanticLabel"]),
                np.array(local_to_world(stage.GetPrimAtPath(str(row["name"])), stage_time(stage))),
            )
            for row in helpers.get_instance_mappings()
        ]

    def get_semantic_ids(self, semantic_data: Any = ((),)) -> list[int]:
        """Return the ids in an image."""
        return np.unique(np.asarray(semantic_data)).tolist()

    def get_semantic_id_map(self, semantic_labels: Sequence[str] = ()) -> dict[str, int]:
        """Return the id of each label; 0 for one that no prim has."""
        known = self._labels()
        return {label: next((key for key, name in known.items() if name == label), 0) for label in semantic_labels}

    def get_semantic_label_map(self, semantic_ids: Sequence[int] = ()) -> dict[int, str]:
        """Return the label of each id; "" for one that no prim has."""
        known = self._labels()
        return {key: known.get(int(key), "") for key in semantic_ids}

    def get_mapped_semantic_data(
        self,
        semantic_data: Any = ((),),
        user_semantic_label_map: Mapping[str, int] | None = None,
        remap_using_base_class: bool = False,
    ) -> list[list[int]]:
        """Return an image of ids in which labels have ids of the user's own; others stay as they are.

        remap_using_base_class: look up what is after the last colon of a label.
        """
        image = np.array(semantic_data)
        mapped = image.copy()
        for key, label in self.get_semantic_label_map(self.get_semantic_ids(image)).items():
            name = label.split(":")[-1] if remap_using_base_class else label
            if name in (user_semantic_label_map or {}):
                mapped[image == key] = (user_semantic_label_map or {})[name]
        return mapped.tolist()

    def _enable(self, names: Iterable[str], viewport: Any) -> None:
        sensors.enable_sensors(viewport, [_known(name)[0] for name in names if name not in ("camera", "pose")])

    def _labels(self) -> dict[int, str]:
        return {int(row["semanticId"]): str(row["semanticLabel"]) for row in helpers.get_instance_mappings()}


def _known(name: str) -> tuple[SensorType, Callable[..., Any]]:
    if name not in _SENSORS:
        raise ArgumentError(f"SyntheticDataHelper has no sensor {name!r}; known: {', '.join(_SENSORS)}, camera, pose")
    return _SENSORS[name]
