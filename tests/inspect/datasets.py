"""Small datasets written by hand after the formats' description, with numbers that the tests know."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 64, 48
FOCAL = 80.0
ORDER = ["Center", "LDB", "LDF", "LUB", "LUF", "RDB", "RDF", "RUB", "RUF"]
DOPE_ORDER = ["LUF", "RUF", "RDF", "LDF", "LUB", "RUB", "RDB", "LDB", "Center"]

# A camera at (1, 2, 5), looking along world -z, up is world +y: world to camera is a shift.
VIEW = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [-1, -2, -5, 1]]


def keypoints_in_camera(center, size, order=ORDER) -> list[list[float]]:
    """An upright box whose middle lies at `center` in the camera's frame."""
    half = np.array(size) / 2.0
    corners = {"Center": np.array(center, float)}
    for x, y, z in itertools.product("LR", "DU", "BF"):
        sides = np.array(["LR".index(x), "DU".index(y), "BF".index(z)]) * 2.0 - 1.0
        corners[x + y + z] = np.array(center) + sides * half
    return [corners[name].tolist() for name in order]


def pixel(point) -> tuple[float, float]:
    """By similar triangles: right of the middle is +x, below it -y."""
    return (WIDTH / 2 + FOCAL * point[0] / -point[2], HEIGHT / 2 + FOCAL * point[1] / point[2])


def camera_data(style: str | None) -> dict:
    camera = {
        "intrinsics": {"fx": FOCAL, "fy": FOCAL, "cx": WIDTH / 2, "cy": HEIGHT / 2},
        "camera_view_matrix": VIEW,
        "camera_projection_matrix": [[0.0] * 4] * 4,
    }
    if style is None:
        camera |= {"aperture": [20.0, 15.0], "aperture_offset": [0, 0], "focal_length": 25.0}
        camera |= {"resolution": [WIDTH, HEIGHT], "meters_per_scene_unit": 1.0}
    if style == "centerpose":
        camera |= {"width": WIDTH, "height": HEIGHT}
    return camera


def pose_object(style, label, center, size, visibility=1.0, location=None) -> dict:
    order = DOPE_ORDER if style == "dope" else ORDER
    points = keypoints_in_camera(center, size, order)
    pixels = [[round(u), round(v)] for u, v in map(pixel, points)]
    values = {"class" if style == "dope" else "label": label, "prim_path": f"/World/{label}", "visibility": visibility}
    if style is None:
        values |= {"size": size, "cuboid_keypoints_camera_frame": points, "cuboid_keypoints_projected": pixels}
    else:
        values |= {"location": location or center, "quaternion_xyzw": [0, 0, 0, 1], "projected_cuboid": pixels}
    if style == "centerpose":
        values |= {"scale": size, "keypoints_3d": points}
    return values | {"truncation_ratio": 0.0}


def write_pose(folder: Path, number: int, objects: list[dict], style: str | None = None, shade: int = 90) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    picture(folder / f"{number:06d}.png", shade)
    order = DOPE_ORDER if style == "dope" else ORDER
    values = {"camera_data": camera_data(style), "keypoint_order": order, "objects": objects}
    (folder / f"{number:06d}.json").write_text(json.dumps(values))


def picture(path: Path, shade: int = 90, size=(WIDTH, HEIGHT)) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGBA", size, (shade, 120, 60, 255)).save(path)


BOX_2D = [
    ("semanticId", "<u4"),
    ("x_min", "<i4"),
    ("y_min", "<i4"),
    ("x_max", "<i4"),
    ("y_max", "<i4"),
    ("occlusionRatio", "<f4"),
]
BOX_3D = [
    ("semanticId", "<u4"), ("x_min", "<f4"), ("y_min", "<f4"), ("z_min", "<f4"), ("x_max", "<f4"), ("y_max", "<f4"),
    ("z_max", "<f4"), ("transform", "<f4", (4, 4)), ("occlusionRatio", "<f4"),
]  # fmt: skip


class BasicFolder:
    """Writes the files of one render product; `where(kind)` gives the folder or prefix of its files."""

    def __init__(self, root: Path, layout: str = "{kind}") -> None:
        self.root, self.layout = root, layout

    def path(self, kind: str, rest: str) -> Path:
        path = self.root / self.layout.format(kind=kind + rest, annotator=kind)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    def rgb(self, frame: int, shade: int = 90) -> None:
        picture(self.path("rgb", f"_{frame:04d}.png"), shade)

    def boxes(self, kind: str, frame: int, rows: list, labels=("mug", "crate"), prims=None) -> None:
        dtype = BOX_3D if kind.endswith("3d") else BOX_2D
        np.save(self.path(kind, f"_{frame:04d}.npy"), np.array(rows, dtype=dtype))
        table = {str(index): {"class": name} for index, name in enumerate(labels)}
        self.path(kind, f"_labels_{frame:04d}.json").write_text(json.dumps(table))
        prims = prims or [f"/World/thing_{index}" for index in range(len(rows))]
        self.path(kind, f"_prim_paths_{frame:04d}.json").write_text(json.dumps(prims))

    def camera(self, frame: int, **changes) -> None:
        values = {
            "cameraModel": "pinhole",
            "cameraAperture": [20.0, 15.0],
            "cameraFocalLength": 25.0,  # 64 px x 25 / 20 = 80 px
            "cameraProjection": (np.diag([2.5, 10 / 3, 0, 0]) + np.array([[0] * 4] * 2 + [[0, 0, 0, -1], [0] * 4]))
            .ravel()
            .tolist(),
            "cameraViewTransform": np.array(VIEW, float).ravel().tolist(),
            "metersPerSceneUnit": 1.0,
            "renderProductResolution": [WIDTH, HEIGHT],
            **changes,
        }
        self.path("camera_params", f"_{frame:04d}.json").write_text(json.dumps(values))

    def depth(self, frame: int, values: np.ndarray) -> None:
        np.save(self.path("distance_to_camera", f"_{frame:04d}.npy"), values.astype(np.float32))

    def mask(self, frame: int, values: np.ndarray) -> None:
        Image.fromarray(values).save(self.path("semantic_segmentation", f"_{frame:04d}.png"))
        self.path("semantic_segmentation", f"_labels_{frame:04d}.json").write_text("{}")
