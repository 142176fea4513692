"""Occlusion: outlines of objects as if they were alone, how much of each is visible, and what hides it.

    python examples/hidden_parts.py [--out FOLDER] [--width PIXELS]

Shows the annotators amodal_instance_segmentation and visibility, which go beyond Replicator's, read without a writer.
Writes hidden_parts.json and hidden_parts.png, which shows the whole outline of every object, to FOLDER
(_out/hidden_parts).
"""

import argparse
import json
from pathlib import Path

from PIL import Image

import usdsdg as rep

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/hidden_parts")
parser.add_argument("--width", type=int, default=480)
args = parser.parse_args()

rep.set_global_seed(4)
colors = {"wall": (0.6, 0.15, 0.1), "crate": (0.1, 0.3, 0.6), "ball": (0.15, 0.5, 0.15)}
of_class = {
    name: {"semantics": [("class", name)], "material": rep.create.material_omnipbr(diffuse=color)}
    for name, color in colors.items()
}
rep.create.cube(position=(-0.5, -1, 0.9), scale=(1, 0.1, 1.8), **of_class["wall"])
rep.create.cube(position=(0, 2.5, 1), scale=(2, 1, 2), **of_class["crate"])
rep.create.sphere(position=(1.5, 4, 0.8), scale=1.6, **of_class["ball"])
rep.create.plane(scale=30)
rep.create.light(light_type="Dome", intensity=300)
rep.create.light(light_type="Distant", intensity=2500, rotation=(40, -25, 0))
camera = rep.create.camera(position=(0, -5, 1), look_at=(0, 0, 1), clipping_range=(0.1, 100))
product = rep.create.render_product(camera, (args.width, args.width // 2))

names = ["rgb", "visibility", "amodal_instance_segmentation"]
annotators = {name: rep.AnnotatorRegistry.get_annotator(name) for name in names}
for annotator in annotators.values():
    annotator.attach(product)
rep.orchestrator.step(rt_subframes=16)
image, visibility, amodal = (annotators[name].get_data() for name in names)

classes = {number: labels["class"] for number, labels in amodal["info"]["idToSemantics"].items()}
report = {}
for row, hidden_by in zip(visibility["data"], visibility["info"]["hiddenBy"], strict=True):
    report[classes[str(row["instanceId"])]] = {
        "visible share": float(row["visibleRatio"]),
        "whole box": [int(row[edge]) for edge in ("x_min", "y_min", "x_max", "y_max")],
        "hidden by": {classes[number]: pixels for number, pixels in hidden_by.items()},
    }
image = image[..., :3].copy()
for mask in amodal["data"]:
    # A pixel of the mask is on the outline if one of its neighbors is not in the mask.
    inside = mask[1:-1, 1:-1] & mask[2:, 1:-1] & mask[:-2, 1:-1] & mask[1:-1, 2:] & mask[1:-1, :-2]
    image[1:-1, 1:-1][mask[1:-1, 1:-1] & ~inside] = 255
args.out.mkdir(parents=True, exist_ok=True)
(args.out / "hidden_parts.json").write_text(json.dumps(report, indent=2))
Image.fromarray(image).save(args.out / "hidden_parts.png", optimize=True)
print(f"outlines of {len(report)} objects in {args.out}")
