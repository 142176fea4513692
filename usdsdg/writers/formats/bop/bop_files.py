"""Names, units and axes of the files of a BOP dataset, for its writer and its readers."""

from __future__ import annotations

NAME = "BopWriter"
RGB, DEPTH, MASK, MASK_VISIB = "rgb", "depth", "mask", "mask_visib"  # folders of a scene
CAMERAS, POSES, INFOS = "scene_camera", "scene_gt", "scene_gt_info"  # tables of a scene
CAMERA, MODELS = "camera.json", "models"
MODELS_INFO = f"{MODELS}/models_info.json"
MODEL_NAMES = f"{MODELS}/names.json"  # no file of BOP's, whose other files tell no names
MILLIMETERS = 1000.0  # per meter
FARTHEST = 0xFFFF  # steps of a depth picture


def scene_folder(split: str, number: int) -> str:
    """Return the folder of a scene."""
    return f"{split}/{number:06d}"


def table_of(scene: str, name: str) -> str:
    """Return the file of one of a scene's tables."""
    return f"{scene}/{name}.json"


def picture_of(scene: str, kind: str, frame: int, extension: str = "png") -> str:
    """Return the file of a color or depth picture."""
    return f"{scene}/{kind}/{frame:06d}.{extension}"


def mask_of(scene: str, kind: str, frame: int, index: int) -> str:
    """Return the file of a mask of the object at `index` of a frame's lists."""
    return f"{scene}/{kind}/{frame:06d}_{index:06d}.png"


def model_of(obj_id: int) -> str:
    """Return the file of a model."""
    return f"{MODELS}/obj_{obj_id:06d}.ply"
