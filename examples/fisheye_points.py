"""A fisheye and a pinhole camera at the same position, and point clouds from their depths.

    python examples/fisheye_points.py [--out FOLDER] [--width PIXELS]

Shows an f-theta lens of 190 degrees, and CameraView.rays, which gives world-space points from distances for any lens.
Writes the two images to views.png and their colored points to pinhole.ply and fisheye.ply in FOLDER
(_out/fisheye_points).
"""

import argparse
import math
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

import usdsdg as rep
from usdsdg.stage.cameras.camera_view import read_camera

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/fisheye_points")
parser.add_argument("--width", type=int, default=240)
args = parser.parse_args()
size = (args.width, args.width)

rep.set_global_seed(4)
rep.create.plane(scale=20)
rep.create.light(light_type="Dome", intensity=400)
rep.create.light(light_type="Distant", intensity=2500, rotation=(35, 30, 0))
for k in range(12):
    position = (4 * math.cos(k * math.pi / 6), 4 * math.sin(k * math.pi / 6), 0.75)
    paint = rep.create.material_omnipbr(diffuse=[(0.6, 0.1, 0.1), (0.1, 0.4, 0.15), (0.1, 0.25, 0.6)][k % 3])
    rep.create.cube(position=position, scale=(0.8, 0.8, 1.5), material=paint)

# The angle from the axis is `fisheye_polynomial_b` times the distance from the center, in pixels of the nominal image.
fisheye = rep.create.camera(
    position=(0, 0, 2), clipping_range=(0.01, 100), projection_type="fisheyePolynomial", fisheye_max_fov=190,
    fisheye_nominal_width=1000, fisheye_nominal_height=1000, fisheye_optical_centre_x=500,
    fisheye_optical_centre_y=500, fisheye_polynomial_b=math.radians(95) / 500,
)  # fmt: skip
pinhole = rep.create.camera(position=(0, 0, 2), clipping_range=(0.01, 100), focal_length=10)
annotators = []
for camera in (pinhole, fisheye):
    product = rep.create.render_product(camera, size)
    annotators.append([rep.AnnotatorRegistry.get_annotator(name) for name in ("rgb", "distance_to_camera")])
    for annotator in annotators[-1]:
        annotator.attach(product)
rep.orchestrator.step(rt_subframes=16)

args.out.mkdir(parents=True, exist_ok=True)
columns, rows = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
images = []
for name, camera, (rgb, distance_to_camera) in zip(("pinhole", "fisheye"), (pinhole, fisheye), annotators, strict=True):
    view = read_camera(rep.get_stage(), camera.prims[0], size)
    origins, directions = view.rays(np.stack([columns, rows], -1))
    distance = distance_to_camera.get_data().reshape(-1, 1)
    hit = np.isfinite(distance[:, 0])
    points = (origins + directions * distance)[hit] @ view.local_to_world[:3, :3] + view.local_to_world[3, :3]
    images.append(rgb.get_data()[..., :3])
    trimesh.PointCloud(points, images[-1].reshape(-1, 3)[hit]).export(args.out / f"{name}.ply")
    print(f"{len(points)} points of the {name} in {args.out / name}.ply")
Image.fromarray(np.hstack(images)).save(args.out / "views.png", optimize=True)
