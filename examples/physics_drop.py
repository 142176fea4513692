"""Boxes that fall, and are tossed up whenever the script sends an event.

    python examples/physics_drop.py [--out FOLDER] [--width PIXELS]

Shows rigid bodies, physics that runs between captures, a trigger on a custom event, and labels of the simulated poses.
Writes picture.png, boxes in the air, on the floor and tossed, and heights.json, the heights of their centers in meters
at these times, to FOLDER (_out/physics_drop).
"""

import argparse
import json
from pathlib import Path

import numpy as np
from PIL import Image

import usdsdg as rep

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/physics_drop")
parser.add_argument("--width", type=int, default=240)
args = parser.parse_args()

rep.set_global_seed(4)
wood = rep.create.material_omnipbr(diffuse=(0.30, 0.17, 0.09), roughness=0.6)
floor = rep.create.cube(position=(0, 0, -0.5), scale=(12, 12, 1), material=wood)
positions = [(0.8 * (k % 3 - 1), 0.8 * (k // 3 % 3 - 1), 2.0 + 0.8 * (k // 9)) for k in range(18)]
boxes = rep.create.cube(position=positions, scale=0.5, count=18, semantics=[("class", "box")])
rep.physics.collider(input_prims=floor)
rep.physics.rigid_body(input_prims=boxes)
with rep.trigger.on_custom_event("toss"), boxes:
    rep.randomizer.color(colors=rep.distribution.uniform((0.05, 0.05, 0.05), (0.8, 0.8, 0.8)))
    rep.physics.rigid_body(
        velocity=rep.distribution.uniform((-1, -1, 3), (1, 1, 6)),
        angular_velocity=rep.distribution.uniform((-360, -360, -360), (360, 360, 360)),
    )
    rep.physics.simulate(0.4)

rep.create.light(light_type="Dome", intensity=300)
rep.create.light(light_type="Distant", intensity=2500, rotation=(35, 30, 0))
camera = rep.create.camera(position=(4, -4, 2.6), look_at=(0, 0, 1), clipping_range=(0.1, 100))
product = rep.create.render_product(camera, (args.width, args.width))
rgb, boxes_3d = (rep.AnnotatorRegistry.get_annotator(name) for name in ("rgb", "bounding_box_3d"))
rgb.attach(product)
boxes_3d.attach(product)

images, heights = [], {}


def capture(name: str) -> None:
    rep.orchestrator.step(rt_subframes=16, delta_time=0.0)
    images.append(rgb.get_data()[..., :3])
    # The last row of a box's matrix is its position.
    heights[name] = boxes_3d.get_data()["data"]["transform"][:, 3, 2].tolist()


rep.physics.simulate(0.25)
capture("after a quarter of a second")
rep.physics.simulate(1.25)
capture("at rest")
rep.utils.send_og_event("toss")
capture("tossed")

args.out.mkdir(parents=True, exist_ok=True)
Image.fromarray(np.hstack(images)).save(args.out / "picture.png", optimize=True)
(args.out / "heights.json").write_text(json.dumps(heights, indent=2))
print(f"three images of {len(positions)} boxes in {args.out}")
