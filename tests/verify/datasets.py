"""A small scene that moves, and datasets of it in every format that we write."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, UsdGeom

import usdsdg as rep
from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import session
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels

SIZE = (96, 64)
CATEGORIES = {
    name: {"name": name, "id": number, "color": color}
    for name, number, color in (
        ("mug", 11, (200, 30, 30)), ("can", 12, (30, 200, 30)), ("box", 13, (30, 30, 200)),
        ("ball", 14, (200, 200, 30)), ("lid", 15, (30, 200, 200)), ("never", 16, (200, 30, 200)),
    )
}  # fmt: skip
CLASSES = {name: [*CATEGORIES[name]["color"], 255] for name in CATEGORIES}

EVERYTHING = (
    "rgb", "bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d", "semantic_segmentation",
    "instance_segmentation", "instance_id_segmentation", "distance_to_camera", "distance_to_image_plane", "occlusion",
    "normals", "motion_vectors", "camera_params", "pointcloud",
)  # fmt: skip
YCB_VIDEO: dict[str, Any] = {
    **dict.fromkeys(("rgb", "bounding_box_2d_tight", "semantic_segmentation", "distance_to_image_plane", "pose"), True),
    "num_frames": 4,
    "class_name_to_index_map": {"mug": 1, "can": 2, "box": 3, "ball": 4},
}
# Writers and their options, by the name of the folder.
DATASETS: dict[str, tuple[str, dict[str, Any], int]] = {  # number of cameras
    "basic": ("BasicWriter", dict.fromkeys(EVERYTHING, True), 1),
    "basic_ids": (
        "BasicWriter",
        dict.fromkeys(EVERYTHING[:10], True)
        | {f"colorize_{kind}_segmentation": False for kind in ("semantic", "instance", "instance_id")}
        | {"image_output_format": "jpg", "camera_params": True, "colorize_depth": True},
        2,
    ),
    "coco": ("CocoWriter", {"coco_categories": CATEGORIES}, 1),
    "coco_plain": ("CocoWriter", {"splits": {"train": 3, "val": 1}, "keypoints": True, "panoptic": True}, 2),
    "coco_polygons": ("CocoWriter", {"plain_names": True, "segmentation": "polygon", "min_pixels": 4}, 1),
    "voc": ("VocWriter", {"splits": {"train": 3, "val": 1}, "min_visibility": 0.4, "image_output_format": "png"}, 2),
    "cvat": ("CvatWriter", {}, 2),
    "cvat_polygons": ("CvatWriter", {"shape": "polygon", "min_pixels": 4}, 1),
    "cvat_boxes": ("CvatWriter", {"shape": "box", "min_visibility": 0.3}, 1),
    "kitti": ("KittiWriter", {"mapping_dict": CLASSES, "bbox_height_threshold": 2, "omit_semantic_type": True,
                              "colorize_instance_segmentation": True}, 1),
    "kitti_plain": ("KittiWriter", {"splits": {"train": 3, "val": 1}, "bbox_height_threshold": 2}, 2),
    "pose": ("PoseWriter", {"exact_camera_frame": True, "skip_empty_frames": False}, 1),
    "dope": ("PoseWriter", {"exact_camera_frame": True, "format": "dope", "skip_empty_frames": False}, 1),
    "centerpose": ("PoseWriter", {"exact_camera_frame": True, "format": "centerpose"}, 2),
    "dope_node": ("DOPEWriter", {"class_name_to_index_map": {}}, 2),
    "dope_exact": ("DOPEWriter", {"class_name_to_index_map": {}, "exact": True}, 1),
    "ycb_node": ("YCBVideoWriter", YCB_VIDEO, 1),
    "ycb_exact": ("YCBVideoWriter", {**YCB_VIDEO, "exact": True}, 2),
    "yolo": ("YoloWriter", {"task": "detect"}, 1),
    "outlines": ("YoloWriter", {"task": "segment", "splits": {"train": 3, "val": 1}, "min_pixels": 5}, 2),
    "obb": ("YoloWriter", {"task": "obb"}, 1),
    "keypoints": ("YoloWriter", {"task": "pose", "min_visibility": 0.1}, 1),
    "bop": ("BopWriter", {}, 2),
    "webdataset": ("WebDatasetWriter", {"masks": True, "depth": True, "shard_samples": 3}, 2),
    "tars": ("WebDatasetWriter", {"image_output_format": "jpg", "splits": {"train": 1, "val": 1}, "min_pixels": 9}, 1),
    "cosmos": ("CosmosWriter", {}, 1),
    "drawn": ("DataVisualizationWriter", {
        "bounding_box_2d_tight": True, "bounding_box_2d_loose": True, "bounding_box_3d": True,
        "bounding_box_2d_loose_params": {"background": "rgb"},
    }, 1),
}  # fmt: skip

if find_spec("pyarrow"):  # of the extra `parquet`
    DATASETS["parquet"] = ("ParquetWriter", {"masks": True, "shard_samples": 3, "row_group_samples": 2}, 2)


def make(
    folder: Path,
    names: Iterable[str] = DATASETS,
    *,
    frames: int = 4,
    seed: int = 1,
    edit: Callable[[int], None] = lambda frame: None,
) -> Path:
    """Write the named datasets, each into a folder of its name; return `folder`. `edit` changes the stage further."""
    session.restart()
    set_global_seed(seed)
    scene = Scene(seed)
    products = [rep.create.render_product(path, SIZE) for path in scene.cameras]
    for name in names:
        kind, options, cameras = DATASETS[name]
        writer = rep.writers.get(kind)
        writer.initialize(output_dir=str(folder / name), **options)
        writer.attach(products[:cameras])
    for frame in range(frames):
        scene.move()
        edit(frame)
        rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    for writer in list(session.current().writers):
        writer.on_final_frame()
        writer.detach()
    rep.orchestrator.wait_until_complete()
    session.restart()
    return folder


class Scene:
    """Labeled things on an unlabeled floor, one of them with a labeled part, that move from frame to frame."""

    def __init__(self, seed: int, *, count: int = 7) -> None:
        self._random = np.random.default_rng(seed)
        stage = new_stage()
        floor = UsdGeom.Cube.Define(stage, "/World/Floor")
        floor.CreateSizeAttr(1.0)
        floor.AddTranslateOp().Set(Gf.Vec3d(0, 0, -0.55))
        floor.AddScaleOp().Set(Gf.Vec3f(8, 8, 1))
        self._things = [self._thing(index) for index in range(count)]
        self.cameras = ("/World/Left", "/World/Right")
        for path, aside in zip(self.cameras, (-1.0, 1.5)):
            camera = UsdGeom.Camera.Define(stage, path)
            camera.AddTransformOp().Set(look_at_matrix((aside, -5, 3), (0, 0, 0), up=(0, 0, 1)))
            camera.CreateClippingRangeAttr(Gf.Vec2f(0.05, 100.0))
        rep.create.light(light_type="dome")

    def _thing(self, index: int) -> UsdGeom.Xformable:
        stage, names = current_stage(), ("mug", "can", "box", "ball")
        path, label = f"/World/Thing_{index}", names[index % len(names)]
        root = UsdGeom.Xform.Define(stage, path)
        add_labels(root.GetPrim(), {"class": [label]})
        body = (UsdGeom.Cylinder, UsdGeom.Cone, UsdGeom.Cube, UsdGeom.Sphere)[index % 4].Define(stage, f"{path}/Body")
        body.CreateDisplayColorAttr([Gf.Vec3f(*self._random.uniform(0, 1, 3).tolist())])
        body.AddScaleOp().Set(Gf.Vec3f(*self._random.uniform(0.25, 0.45, 3).tolist()))
        if index == 0:
            lid = UsdGeom.Cube.Define(stage, f"{path}/Lid")
            lid.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.5))
            lid.AddScaleOp().Set(Gf.Vec3f(0.3, 0.3, 0.06))
            add_labels(lid.GetPrim(), {"class": ["lid"]})
        if label == "can":
            set_keypoints(root.GetPrim(), {"top": (0, 0, 0.3), "front": (0, -0.3, 0), "side": (0.3, 0, 0)})
        root.AddTranslateOp()
        root.AddOrientOp()
        return root

    def move(self) -> None:
        """Place everything anew, and hide some of it."""
        for index, thing in enumerate(self._things):
            translate, orient = thing.GetOrderedXformOps()
            translate.Set(Gf.Vec3d(*self._random.uniform((-1.7, -1.5, 0.2), (1.7, 1.5, 1.0)).tolist()))
            turn = self._random.normal(size=4)
            turn = (turn / np.linalg.norm(turn)).tolist()
            orient.Set(Gf.Quatf(turn[0], *turn[1:]))
            hidden = index > 3 and self._random.random() < 0.3
            thing.GetVisibilityAttr().Set("invisible" if hidden else "inherited")
