"""Arguments that are meant by names which a function does not have."""

from collections.abc import Iterable

from usdsdg.arguments.registry import near_misses

# What arguments are called by users of other programs.
_LIKELY_ARGUMENTS = {
    "translation": "position", "translate": "position", "location": "position", "pos": "position",
    "orientation": "rotation", "orient": "rotation", "rot": "rotation", "euler": "rotation", "type": "light_type",
    "label": "semantics", "labels": "semantics", "class_name": "semantics", "frames": "num_frames",
    "count": "num_frames", "surface": "surface_prims", "color": "diffuse", "fov": "focal_length",
    "target": "look_at", "depth": "distance_to_image_plane", "bbox": "bounding_box_2d_tight",
    "bounding_box": "bounding_box_2d_tight", "segmentation": "semantic_segmentation", "image": "rgb",
    "path": "output_dir", "output": "output_dir", "out_dir": "output_dir", "folder": "output_dir",
}  # fmt: skip


def near_arguments(name: str, known: Iterable[str]) -> list[str]:
    """Return up to three of the `known` arguments that may be meant by a name which is none of them, best first."""
    listed = list(known)
    likely = _LIKELY_ARGUMENTS.get(name.casefold())
    if likely in listed:
        return [likely]
    holding = [each for each in listed if name.casefold() in each.casefold().split("_")]
    return holding[:3] if len(holding) in (1, 2, 3) else near_misses(name, listed)
