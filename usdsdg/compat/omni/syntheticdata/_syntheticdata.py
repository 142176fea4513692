"""`omni.syntheticdata._syntheticdata`: the types of sensors, and ids of the segmentations."""

import enum

import numpy as np

from usdsdg.compat.omni.syntheticdata.instance_mappings import InstanceMapping, gprim_ids, instance_mappings


class SensorType(enum.Enum):
    """What a sensor measures."""

    Rgb = 0
    Depth = 1
    DepthLinear = 2
    DistanceToImagePlane = 3
    DistanceToCamera = 4
    InstanceSegmentation = 5
    SemanticSegmentation = 6
    BoundingBox2DTight = 7
    BoundingBox2DLoose = 8
    BoundingBox3D = 9
    MotionVector = 10
    Normal = 11
    CrossCorrespondence = 12
    Occlusion = 13
    Camera3dPosition = 14


class SyntheticDataInterface:
    """Ids that the segmentations of `sensors` have."""

    def get_instance_segmentation_id(self, path: str) -> np.ndarray:
        """Return the ids (uint32) of the gprim at `path`: one, or none if it is not drawn."""
        return np.array([gprim_ids()[path]] if path in gprim_ids() else [], np.uint32)

    def get_semantic_segmentation_id_from_data(self, semantic_type: str, semantic_data: str) -> int:
        """Return the id of the label `semantic_data` of type "class"; 0 if no prim has it."""
        wanted = (row.semantic_id for row in instance_mappings() if row.label == semantic_data)
        return next(wanted, 0) if semantic_type == "class" else 0

    def get_instance_mapping_list(self) -> list[InstanceMapping]:
        """Return the labeled prims with the ids of their gprims."""
        return instance_mappings()


_interface = SyntheticDataInterface()


def acquire_syntheticdata_interface(plugin_name: str | None = None, library_path: str | None = None) -> object:
    return _interface


def release_syntheticdata_interface(interface: object) -> None:
    """Do nothing: the interface holds no state."""
