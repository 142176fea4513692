"""A custom writer: images of coins on a table, with labels for YOLO.

    python examples/yolo_writer.py [--out FOLDER] [--width PIXELS] [--frames N]

Shows a subclass of Writer, scattering without collisions, and `import usdsdg as rep` in a plain Python program. Writes
picture_N.png and picture_N.txt, one line "class x y width height" for each coin, as fractions of the image size, to
FOLDER (_out/yolo_writer).
"""

import argparse
import os

import usdsdg as rep

CLASSES = ["copper", "silver"]


class YoloWriter(rep.Writer):
    """Writes an image and its boxes whenever the render product is captured."""

    def __init__(self, output_dir):
        self.backend = rep.backends.get("DiskBackend")
        self.backend.initialize(output_dir=output_dir)
        self.annotators = [rep.AnnotatorRegistry.get_annotator(name) for name in ("rgb", "bounding_box_2d_tight")]
        self._number = 0

    def write(self, data):
        height, width = data["rgb"].shape[:2]
        boxes, labels = data["bounding_box_2d_tight"]["data"], data["bounding_box_2d_tight"]["info"]["idToLabels"]
        lines = []
        for box in boxes:
            # Replicator's boxes give their first and their last pixel.
            x, y, right, bottom = box["x_min"], box["y_min"], box["x_max"] + 1, box["y_max"] + 1
            center = (x + right) / 2 / width, (y + bottom) / 2 / height
            size = (right - x) / width, (bottom - y) / height
            number = CLASSES.index(labels[str(box["semanticId"])]["class"])
            lines.append(" ".join([str(number), *(f"{value:.6f}" for value in (*center, *size))]))
        self.backend.write_image(f"picture_{self._number:04}.png", data["rgb"])
        self.backend.write_blob(f"picture_{self._number:04}.txt", "\n".join(lines).encode())
        self._number += 1


parser = argparse.ArgumentParser()
parser.add_argument("--out", default="_out/yolo_writer")
parser.add_argument("--width", type=int, default=320)
parser.add_argument("--frames", type=int, default=4)
args = parser.parse_args()

rep.set_global_seed(4)
rep.create.light(light_type="Dome", intensity=300)
rep.create.light(light_type="Distant", intensity=2500, rotation=(30, 20, 0))
wood = rep.create.material_omnipbr(diffuse=(0.30, 0.17, 0.09), roughness=0.6)
table = rep.create.plane(scale=(3.6, 2.6, 1), material=wood)
coins = [
    rep.create.cylinder(
        scale=(0.4, 0.4, 0.05), count=6, semantics=[("class", name)],
        material=rep.create.material_omnipbr(diffuse=color, metallic=1.0, roughness=0.35),
    )
    for name, color in zip(CLASSES, [(0.95, 0.55, 0.35), (0.9, 0.9, 0.9)], strict=True)
]  # fmt: skip
with rep.trigger.on_frame(rt_subframes=16), rep.create.group(coins):
    rep.randomizer.scatter_2d(table, check_for_collisions=True)
camera = rep.create.camera(position=(0, 0, 5), rotation=(0, -90, 90), clipping_range=(0.1, 100))

rep.WriterRegistry.register(YoloWriter)
writer = rep.WriterRegistry.get("YoloWriter")
writer.initialize(output_dir=os.path.abspath(args.out))
writer.attach(rep.create.render_product(camera, (args.width, args.width * 3 // 4)))
rep.orchestrator.run(num_frames=args.frames)
