"""DOPE, CenterPose and YCB-Video: datasets as those projects' own training reads them, and poses solved anew.

The readers here are written after what DOPE's and CenterPose's training and YCB-Video's readers ask of files.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.io import loadmat
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.soak.formats.scene import CLASSES, SIZE, Wanted, make
from usdsdg.verify import verify

Row = tuple[str, str, bool]
INDICES = {name: index + 1 for index, name in enumerate(CLASSES)}
EVERYTHING = dict.fromkeys(
    ("rgb", "bounding_box_2d_tight", "semantic_segmentation", "distance_to_image_plane", "pose"), True
)
# DOPE's cuboid in its own axes, x right, y down, z ahead: the far face around from the top right, then the near one.
DOPE_CUBOID = np.array([(x, y, z) for z in (1, -1) for x, y in ((1, -1), (-1, -1), (-1, 1), (1, 1))]) / 2
# CenterPose's, in its order: back and front of bottom and top, left and then right; pairs that a mirror exchanges.
CENTERPOSE_CUBOID = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
CENTERPOSE_MIRRORED = ((0, 4), (2, 6), (1, 5), (3, 7))
_PIXEL = 0.02


def rows(folder: Path, frames: int) -> Iterator[Row]:
    """Write `frames` frames in each format, and yield what was looked at, what came out, and whether it is right."""
    ycb = {"num_frames": frames, "class_name_to_index_map": INDICES, **EVERYTHING}
    dope = {"class_name_to_index_map": INDICES}
    wanted = {
        "dope": Wanted("DOPEWriter", {**dope, "exact": True}),
        "dope_of_two_cameras": Wanted("DOPEWriter", {**dope, "exact": True}, 2),
        "dope_of_isaac_sim": Wanted("DOPEWriter", dope, 2),
        "dope_of_posewriter": Wanted("PoseWriter", {"format": "dope", "exact_camera_frame": True}),
        "centerpose": Wanted("PoseWriter", {"format": "centerpose", "exact_camera_frame": True}),
        "ycb_video": Wanted("YCBVideoWriter", {**ycb, "exact": True}),
        "ycb_video_of_isaac_sim": Wanted("YCBVideoWriter", ycb, 2),
    }
    make(folder, wanted, frames=frames)
    for name in wanted:
        report = verify(folder / name)
        yield f"verify {name}", f"{len(report.faults)} faults in {report.formats.total()} images", not report.faults
    for name in ("dope", "dope_of_two_cameras", "dope_of_isaac_sim", "dope_of_posewriter"):
        yield from _dope(folder / name)
    yield from _dope_solved(folder / "dope")
    yield from _centerpose(folder / "centerpose")
    yield from _ycb_video(folder / "ycb_video")


def dope_samples(root: Path, interest: str) -> Iterator[tuple[np.ndarray, list[Any]]]:
    """Yield pictures and keypoints of the objects of a class, as DOPE's training does of a folder and those below."""
    for picture in sorted(root.rglob("*.png")):
        table = picture.with_suffix(".json")
        if not table.exists():
            continue
        image, found = np.array(Image.open(picture).convert("RGB")), []
        for each in json.loads(table.read_text())["objects"]:
            if each["class"].lower() == interest:
                hidden = [[-100, -100]] * 9
                found.append(each["projected_cuboid"] if each["visibility"] > 0 else hidden)
        yield image, found


def _dope(root: Path) -> Iterator[Row]:
    """DOPE's loader takes nine points of every object, and pictures of one size."""
    pictures = objects = wrong = 0
    for interest in CLASSES:
        for image, found in dope_samples(root, interest):
            pictures += 1
            objects += len(found)
            wrong += image.shape != (SIZE[1], SIZE[0], 3)
            wrong += sum(np.shape(each) != (9, 2) or not np.isfinite(each).all() for each in found)
    # Isaac Sim's files of two cameras are `rp/NNNNNN.json` and `rp/rgb/NNNNNN.png`, which DOPE does not look for.
    if root.name == "dope_of_isaac_sim":
        yield f"DOPE's loader, {root.name}", f"{pictures} pairs: pictures and JSON are in two folders", pictures == 0
        return
    what = f"{objects} objects in {pictures // len(CLASSES)} pictures, {wrong} wrong"
    yield f"DOPE's loader, {root.name}", what, objects > 0 and wrong == 0


def _dope_solved(root: Path) -> Iterator[Row]:
    """A cuboid of DOPE with the turn of the file is at the keypoints, by the intrinsics, as in solving for a pose."""
    solved, worst = 0, 0.0
    for table in sorted(root.glob("*.json"))[::4]:
        values = json.loads(table.read_text())
        for each in values["objects"]:
            pixels = np.array(each["projected_cuboid"])
            if each["visibility"] > 0 and (pixels > 0).all() and (pixels < SIZE).all():
                turn = Rotation.from_quat(np.roll(each["quaternion_wxyz"], -1))
                worst = max(worst, _off(pixels, turn, values["camera_data"]["intrinsics"]))
                solved += 1
    yield "DOPE's cuboid with the file's turn", f"{solved} objects, {worst:.4f} px off", solved > 0 and worst < _PIXEL


def _off(pixels: np.ndarray, turn: Rotation, k: dict[str, float]) -> float:
    """Return how far the turned cuboid, wherever and of whatever size fits best, is from keypoints [pixels]."""
    focal, middle = np.array([k["fx"], k["fy"]]), np.array([k["cx"], k["cy"]])
    signs = np.concatenate([DOPE_CUBOID, np.zeros((1, 3))])

    def off(parts: np.ndarray) -> np.ndarray:
        points = np.append(parts[:2], 1.0) + turn.apply(signs * parts[2:])
        return (points[:, :2] / points[:, 2:] * focal + middle - pixels)[:8].ravel()

    spread = np.ptp(pixels, axis=0).max() / k["fx"]
    start = np.concatenate([(pixels[8] - middle) / focal, [spread / 2] * 3])
    found = least_squares(off, start, x_scale=spread, xtol=1e-14, ftol=1e-14)
    return float(np.abs(found.fun).max())


def _centerpose(root: Path) -> Iterator[Row]:
    """What CenterPose's loader reads agrees: points in the camera, in pixels, the size, and the turn."""
    objects = 0
    pixels_off, turned_off, sizes_off, mirrored = 0.0, 0.0, 0.0, 0
    for table in sorted(root.glob("*.json")):
        values = json.loads(table.read_text())
        camera, k = values["camera_data"], values["camera_data"]["intrinsics"]
        mirrored += (camera["width"], camera["height"]) != Image.open(table.with_suffix(".png")).size
        for each in values["objects"]:
            points, pixels = np.array(each["keypoints_3d"]), np.array(each["projected_cuboid"])
            center, corners = points[0], points[1:] - points[0]
            turn = Rotation.from_quat(each["quaternion_xyzw"])
            own = turn.inv().apply(corners)
            sizes_off = max(sizes_off, float(np.abs(own - CENTERPOSE_CUBOID * each["scale"]).max()))
            turned_off = max(turned_off, abs(1.0 - float(np.linalg.norm(each["quaternion_xyzw"]))))
            # A picture that is flipped exchanges left and right, which differ in x only.
            mirrored += any(np.abs(own[a] * (-1, 1, 1) - own[b]).max() > 1e-4 for a, b in CENTERPOSE_MIRRORED)
            mirrored += np.abs(center - points[1:].mean(axis=0)).max() > 1e-5
            ahead = points[:, 2] < -0.05
            drawn = points[:, :2] * (k["fx"], -k["fy"]) / -points[:, 2:] + (k["cx"], k["cy"])
            pixels_off = max(pixels_off, float(np.abs(drawn - pixels)[ahead].max(initial=0.0)))
            objects += 1
    found = f"{objects} objects, {pixels_off:.3f} px, {sizes_off:.1e} m, {mirrored} inconsistent"
    is_right = objects > 0 and pixels_off < 0.51 and sizes_off < 1e-4 and turned_off < 1e-6 and not mirrored
    yield "CenterPose's loader", found, is_right


def _ycb_video(root: Path) -> Iterator[Row]:
    """YCB-Video's readers: masks by class, clouds from depth, and poses that take them to the models' points."""
    base = root / "data/YCB_Video"
    listed = (base / "train.txt").read_text().split()
    objects, wrong, worst = 0, 0, 0.0
    for name in listed:
        stem = str(base / "data" / name)
        label, depth = np.array(Image.open(f"{stem}-label.png")), np.array(Image.open(f"{stem}-depth.png"))
        meta = loadmat(f"{stem}-meta.mat")
        classes = meta["cls_indexes"].flatten().astype(np.int32)
        wrong += set(np.unique(label)) - {0} != set(classes.tolist())
        wrong += len((Path(f"{stem}-box.txt")).read_text().splitlines()) != len(classes)
        for index, own in enumerate(classes):
            if (classes == own).sum() > 1:
                continue  # a mask of a class holds all of its objects
            pose = meta["poses"][:, :, index]
            rows, columns = ((label == own) & (depth != 0)).nonzero()
            z = depth[rows, columns] / meta["factor_depth"][0][0]
            k = meta["intrinsic_matrix"]
            cloud = np.stack([(columns - k[0][2]) * z / k[0][0], (rows - k[1][2]) * z / k[1][1], z], axis=1)
            model = (cloud - pose[:, 3]) @ pose[:, :3]
            worst = max(worst, float(np.abs(model - meta["vertmap"][rows, columns]).max(initial=0.0)))
            objects += 1
    models = [np.loadtxt(path) for path in sorted(root.glob("data/models/*/points.xyz"))]
    found = f"{objects} objects in {len(listed)} frames, clouds {1000 * worst:.3f} mm from the models, {wrong} wrong"
    # Depth is rounded to tenths of a millimeter.
    yield "YCB-Video's readers", found, objects > 0 and worst < 1e-4 and not wrong and len(models) > 0
