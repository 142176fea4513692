"""Read KITTI: `python kitti.py ROWS.json DATASET OBJECTS.json IDS.npz LOWEST`, the least height of a box [pixels].

It runs in a Python of its own, which has Datumaro; nothing here is of usdsdg. Columns are those of the development
kit's readme; lines are read by `readLabels.m`'s format, boxes are made as `computeBox3D.m` makes them, and projected by
P2 as `readCalibration.m` reads it. OBJECTS.json and IDS.npz have what was there: see `records.record`.
"""

import json
import math
import re
import sys
from pathlib import Path

import numpy as np
from heard import listening, row
from PIL import Image

# What readLabels.m asks of a line: %s %f %d and twelve times %f.
_NUMBER = r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
LINE = re.compile(rf"(\S+) ({_NUMBER}) (-?\d+)" + rf" ({_NUMBER})" * 12)
FULLY, PARTLY = 0.95, 0.5  # visible fractions
# Six digits of numbers; of an object of a meter at eight, in pixels.
DIGITS, PIXELS = 1e-5, 0.01


def main() -> None:
    where, dataset, objects, ids, lowest = sys.argv[1:]
    root, images, expected = Path(dataset), np.load(ids), {}
    for name, listed in json.loads(Path(objects).read_text()).items():
        expected[name] = [
            (each, images[name] == place)
            for place, each in enumerate(listed, 1)
            if each["box"][3] - each["box"][1] + 1 >= int(lowest)
        ]
    rows = [*by_development_kit(root, expected)]
    if (root / "training").is_dir():  # which Datumaro looks for
        with listening() as texts:
            rows += [*by_datumaro(root / "training", expected)]
        rows.append(row(texts, "Datumaro"))
    Path(where).write_text(json.dumps(rows))


def labels_of(root: Path, picture: str) -> Path:
    """Return the labels of a picture, in the folder beside that of the pictures."""
    path = root / picture
    names = {"image_2": "label_2", "image_02": "label_02", "rgb": "object_detection"}
    return path.parent.with_name(names[path.parent.name]) / f"{path.stem}.txt"


def by_development_kit(root: Path, expected: dict) -> list:
    """Compare every column with what was there, and the projected boxes with the masks."""
    wrong: dict = {}
    counts = {"objects": 0, "truncated": 0, "partly": 0, "largely": 0}
    off, outside = 0.0, 0.0

    def judge(what: str, is_right: bool, picture: str) -> None:
        if not is_right:
            wrong.setdefault(what, set()).add(picture)

    for picture, wanted in expected.items():
        labels = labels_of(root, picture)
        calibration = read_calibration(labels.parent.with_name("calib") / labels.name)
        lines = labels.read_text().splitlines()
        judge("number of lines", len(lines) == len(wanted), picture)
        for line, (other, mask) in zip(lines, wanted):
            matched = LINE.fullmatch(line)
            judge("columns", matched is not None, picture)
            if matched is None:
                continue
            kind, occluded = matched[1], int(matched[3])
            truncated, _, alpha, *rest = map(float, matched.groups()[1:])
            box, sizes, location, turn = rest[:4], rest[4:7], rest[7:10], rest[10]
            counts["objects"] += 1
            judge("type", kind == other["name"], picture)
            judge("bbox", box == other["box"], picture)
            judge("truncated", 0 <= truncated <= 1 and abs(truncated - other["outside"]) < 1e-4, picture)
            visible = 1.0 - other["hidden"]
            level = 0 if visible >= FULLY - 1e-6 else 1 if visible >= PARTLY - 1e-6 else 2
            judge("occluded", occluded == level, picture)
            counts["truncated"] += truncated > 0
            counts["partly"] += occluded == 1
            counts["largely"] += occluded == 2
            judge("angles", abs(alpha) <= math.pi + 1e-5 and abs(turn) <= math.pi + 1e-5, picture)
            seen_at = math.remainder(turn - math.atan2(location[0], location[2]) - alpha, math.tau)
            judge("alpha", abs(seen_at) < 2e-5, picture)
            corners = compute_box_3d(sizes, location, turn)
            theirs = np.array(other["corners"])
            distance = np.linalg.norm(corners[:, None] - theirs[None], axis=2)
            apart = max(distance.min(axis=0).max(), distance.min(axis=1).max())
            off = max(off, apart)
            judge("3D box", apart < 3 * DIGITS * np.linalg.norm(location), picture)
            beyond = outside_of(calibration["P2"], corners, mask)
            outside = max(outside, beyond)
            judge("the projected box encloses the mask", beyond < PIXELS, picture)
        judge("picture", Image.open(root / picture).size == wanted[0][1].shape[::-1] if wanted else True, picture)
        judge("P0 to P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo", len(calibration) == 7, picture)
    text = ", ".join(f"{what} in {len(each)} pictures as {min(each)}" for what, each in wrong.items())
    enough = len(expected) > 0 and all(counts.values())
    yield [
        "development kit: columns, 3D boxes, projection",
        f"{len(expected)} pictures, {counts}; corners {off:.1e} m off, masks {outside:.4f} px outside; "
        f"different: {text or 'none'}",
        enough and not wrong,
    ]
    lists = {path.stem: path.read_text().split() for path in sorted(root.glob("ImageSets/*.txt"))}
    if (root / "training").is_dir():
        every = sorted(stem for each in lists.values() for stem in each)
        stems = sorted(path.stem for path in (root / "training/image_2").iterdir())
        is_right = every == stems == [f"{number:06d}" for number in range(len(expected))] and set(lists) == {
            "train",
            "val",
        }
        yield ["ImageSets", str({part: len(each) for part, each in lists.items()}), is_right]


def read_calibration(path: Path) -> dict:
    """Return the matrices of a calibration file."""
    rows = (line.partition(":") for line in path.read_text().splitlines() if line)
    return {name: np.array(text.split(), float).reshape(3, -1) for name, _, text in rows}


def compute_box_3d(sizes: list, location: list, turn: float) -> np.ndarray:
    """Return the corners (8, 3) of a box [m]."""
    height, width, length = sizes
    cos, sin = math.cos(turn), math.sin(turn)
    x = np.array([1, 1, -1, -1, 1, 1, -1, -1]) * length / 2
    y = np.array([0, 0, 0, 0, -1, -1, -1, -1]) * height
    z = np.array([1, -1, -1, 1, 1, -1, -1, 1]) * width / 2
    return (np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]) @ np.stack([x, y, z])).T + location


def outside_of(projection: np.ndarray, corners: np.ndarray, mask: np.ndarray) -> float:
    """Return how far the farthest pixel of a mask is outside of the projected box, whose pixels have whole numbers."""
    import cv2

    points = np.c_[corners, np.ones(len(corners))] @ projection.T
    hull = cv2.convexHull((points[:, :2] / points[:, 2:]).astype(np.float32))[:, 0].astype(float)
    pixels = np.argwhere(mask)[:, ::-1].astype(float)
    ahead = np.roll(hull, -1, axis=0) - hull
    normals = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
    normals *= -np.sign(((hull.mean(axis=0) - hull) * normals).sum(axis=1))[:, None]
    return float(np.einsum("ek,pek->pe", normals, pixels[:, None] - hull).max(initial=0.0))


def by_datumaro(training: Path, expected: dict) -> list:
    """Load KITTI's own layout as objects, and as objects with 3D boxes."""
    from datumaro.components.annotation import AnnotationType
    from datumaro.components.dataset import Dataset

    for kind in ("kitti_detection", "kitti3d"):
        loaded = Dataset.import_from(str(training), kind)
        names = [each.name for each in loaded.categories()[AnnotationType.label]]
        items, boxes, wrong = 0, 0, []
        for item in loaded:
            items += 1
            wanted = expected[f"training/image_2/{item.id}.png"]
            own = list(item.annotations)
            is_right = len(own) == len(wanted) and item.media.data.shape[:2] == (240, 320)
            for each, (other, _) in zip(own, wanted):
                boxes += 1
                left, top, right, bottom = other["box"]
                is_right &= [each.x, each.y, each.w, each.h] == [left, top, right - left, bottom - top]
                is_right &= names[each.label] == other["name"]
                if kind == "kitti3d":
                    values = each.attributes
                    corners = compute_box_3d(values["dimensions"], values["location"], values["rotation_y"])
                    middle = np.mean(other["corners"], axis=0)
                    is_right &= np.abs(corners.mean(axis=0) - middle).max() < 3 * DIGITS * np.linalg.norm(middle)
            wrong += [] if is_right else [item.id]
        text = f"{items} of {len(expected)} pictures, {boxes} boxes; different: {wrong[:3] or 'none'}"
        yield [f"Datumaro: {kind}", text, items == len(expected) and boxes > 0 and not wrong]


if __name__ == "__main__":
    main()
