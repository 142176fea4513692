"""Annotators beyond Replicator's, a picture of each: object coordinates, keypoints, oriented and whole boxes, and more.

    python examples/own_annotators.py [--out FOLDER] [--width PIXELS]

Writes amodal_boxes.png, oriented_boxes.png, object_coordinates.png, keypoints.png and correspondence.png to FOLDER
(_out/own_annotators); docs/annotators.md shows them.
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import usdsdg as rep

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/own_annotators")
parser.add_argument("--width", type=int, default=320)
args = parser.parse_args()
WIDTH, HEIGHT = args.width, args.width * 3 // 4

# A table top with crates and a post, some of them beyond the left edge or behind others.
for kind, color, poses in (
    ("crate", (0.6, 0.3, 0.1), [((-2.6, 0.6, 0.5), 20), ((0.2, 0, 0.5), 35), ((1.5, 2.6, 0.5), 70)]),
    ("post", (0.1, 0.3, 0.6), [((-0.9, -0.6, 0.9), 0)]),
):
    for position, turn in poses:
        size = (1.4, 1, 1) if kind == "crate" else (0.35, 0.35, 1.8)
        prim = rep.functional.create.cube(
            position=position, rotation=(0, 0, turn), scale=size, semantics={"class": kind}, name=kind
        )
        material = rep.functional.create.material("OmniPBR.mdl", diffuse_color_constant=color)
        rep.functional.modify.material(prim, material)
        corners = {f"{x}{y}{z}": (x - 0.5, y - 0.5, z - 0.5) for x in (0, 1) for y in (0, 1) for z in (0, 1)}
        rep.functional.modify.keypoints(prim, {f"corner_{name}": point for name, point in corners.items()})
rep.functional.create.plane(scale=30)
rep.functional.create.dome_light(intensity=350)
rep.functional.create.distant_light(intensity=900, rotation=(30, -30, 0))
cameras = [
    rep.functional.create.camera(position=(x, -5, 3.4), look_at=(0, 0.4, 0.4), clipping_range=(0.1, 100), name=name)
    for name, x in (("First", 0), ("Second", 2.5))
]
first, second = (rep.create.render_product(camera, (WIDTH, HEIGHT)) for camera in cameras)

NAMES = ("rgb", "bounding_box_2d_amodal", "oriented_bounding_box_2d", "keypoints", "object_coordinates")
seen = {name: rep.annotators.get(name).attach(first) for name in NAMES}
seen["picture"] = rep.annotators.get("object_coordinates", init_params={"colorize": True}).attach(first)
seen["to second"] = rep.annotators.get("dense_correspondence", init_params={"camera": second.path}).attach(first)
seen["second"] = rep.annotators.get("rgb").attach(second)
rep.orchestrator.step()
data = {name: annotator.get_data() for name, annotator in seen.items()}
args.out.mkdir(parents=True, exist_ok=True)
rgb = Image.fromarray(data["rgb"]).convert("RGB")


def save(image: Image.Image, name: str) -> None:
    image.save(args.out / f"{name}.png")


# Boxes of whole objects: the picture is set into a wider one, which shows where they reach beyond its edge.
MARGIN = WIDTH // 4
wide = Image.new("RGB", (WIDTH + MARGIN, HEIGHT), (40, 40, 40))
wide.paste(rgb, (MARGIN, 0))
for row in data["bounding_box_2d_amodal"]["data"]:
    x0, y0, x1, y1 = (int(row[name]) for name in ("x_min", "y_min", "x_max", "y_max"))
    pen = ImageDraw.Draw(wide)
    pen.rectangle((x0 + MARGIN, y0, x1 + MARGIN, y1), outline=(200, 0, 60))
    pen.text((max(x0 + MARGIN, 0) + 3, y0 + 2), f"{row['truncationRatio']:.0%} outside", fill=(200, 0, 60))
save(wide, "amodal_boxes")

oriented = rgb.copy()
for row in data["oriented_bounding_box_2d"]["data"]:
    ImageDraw.Draw(oriented).polygon([tuple(corner) for corner in row["corners"].tolist()], outline=(200, 0, 60))
save(oriented, "oriented_boxes")

save(Image.fromarray(data["picture"]["data"]).convert("RGB"), "object_coordinates")

# Keypoints: green are visible, red occluded.
marked = rgb.copy()
for row in data["keypoints"]["data"]:
    if row["visibility"]:
        x, y = float(row["x"]), float(row["y"])
        color = (0, 255, 0) if row["visibility"] == 2 else (255, 0, 0)
        ImageDraw.Draw(marked).ellipse((x - 3, y - 3, x + 3, y + 3), outline=color, width=2)
save(marked, "keypoints")

# The second picture, put together from the first: each pixel of the first goes to where its point is there.
pixels, states = data["to second"]["data"], data["to second"]["info"]["visibility"]
there = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
columns, rows = (np.floor(pixels[states == 2][:, k]).astype(int) for k in (0, 1))
there[rows, columns] = data["rgb"][states == 2][:, :3]
pair = Image.new("RGB", (2 * WIDTH, HEIGHT))
pair.paste(Image.fromarray(there), (0, 0))
pair.paste(Image.fromarray(data["second"]).convert("RGB"), (WIDTH, 0))
save(pair, "correspondence")
print(f"{(states == 2).mean():.1%} of the first picture's pixels are visible in the second")
