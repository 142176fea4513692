"""The renderer alone: labels of a ring of cameras in one batch, saved as masks in COCO format.

    python examples/many_cameras.py [--out FOLDER] [--width PIXELS] [--cameras N]

Shows a stage made with USD's own Python API, cameras that are not prims, WarpRenderer.label_batch, and boxes computed
on the device of the labels, also on a GPU. Writes annotations.json, and masks.png with the masks of the first four
cameras, to FOLDER (_out/many_cameras).
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Usd, UsdGeom

from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.writers.formats.shapes.run_length import runs_of_ids
from usdsdg_render.renderer import WarpRenderer

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/many_cameras")
parser.add_argument("--width", type=int, default=160)
parser.add_argument("--cameras", type=int, default=8)
args = parser.parse_args()
width, height = args.width, args.width * 3 // 4

stage = Usd.Stage.CreateInMemory()
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
for k in range(12):
    ball = UsdGeom.Sphere.Define(stage, f"/World/Ball_{k:02}")
    ball.CreateRadiusAttr(0.3)
    turn, radius = 2.4 * k, 0.45 * math.sqrt(k)
    ball.AddTranslateOp().Set(Gf.Vec3d(radius * math.cos(turn), radius * math.sin(turn), 0.08 * k))

turns = np.arange(args.cameras) * 2 * math.pi / args.cameras
poses = [np.array(look_at_matrix((6 * math.cos(turn), 6 * math.sin(turn), 2), (0, 0, 0.4))) for turn in turns]
views = [CameraView(f"camera {k}", width, height, pose, focal_length=35.0) for k, pose in enumerate(poses)]

renderer = WarpRenderer(stage)
renderer.sync()
batch = renderer.label_batch(views, ["instance"])
boxes = batch.boxes(len(renderer.gprims))  # pixels, first and last column and row of each ball in each view
id_images = [labels["instance"] for labels in batch.numpy()]

annotations = []
for image, ids in enumerate(id_images):
    for gprim, lengths in runs_of_ids(ids).items():
        if gprim >= 0:
            pixels, x, y, right, bottom = boxes[image, gprim].tolist()
            annotations.append({
                "id": len(annotations) + 1, "image_id": image, "category_id": gprim, "iscrowd": 0, "area": pixels,
                "bbox": [x, y, right - x + 1, bottom - y + 1],
                "segmentation": {"size": [height, width], "counts": lengths.tolist()},
            })  # fmt: skip
coco = {
    "images": [{"id": image, "width": width, "height": height} for image in range(len(views))],
    "categories": [{"id": gprim, "name": path} for gprim, path in enumerate(renderer.gprims)],
    "annotations": annotations,
}
args.out.mkdir(parents=True, exist_ok=True)
(args.out / "annotations.json").write_text(json.dumps(coco))
# The id -1, where nothing is hit, takes the last color of the palette.
palette = np.random.default_rng(4).integers(60, 256, (len(renderer.gprims) + 1, 3), np.uint8)
palette[-1] = 20
Image.fromarray(palette[np.hstack(id_images[:4])]).save(args.out / "masks.png", optimize=True)
print(f"{len(annotations)} masks of {len(views)} cameras in {args.out}")
