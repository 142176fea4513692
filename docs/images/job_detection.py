"""Four pictures of configs/detection.yaml, with the boxes that COCO's file has."""

import json
import os
from collections import defaultdict
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from usdsdg.scenarios.jobs import load_job

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 720)) // 2, int(os.environ.get("SAMPLES", 32))
CONFIG = Path(__file__).resolve().parents[2] / "configs" / "detection.yaml"

settings = {
    "output_dir": "job_detection",
    "formats": "{coco: {}}",
    "splits": "{train: 1}",
    "num_frames": 4,
    "resolution": f"[{WIDTH}, {WIDTH * 3 // 4}]",
    "rendering.samples": SAMPLES,
    "objects.per_image": "[4, 6]",
    "seed": 4,
}
job, config = load_job(CONFIG, [f"{key}={value}" for key, value in settings.items()])
job.run(config)

dataset = Path("job_detection") / "coco"
coco = json.loads((dataset / "annotations" / "instances_train.json").read_text(encoding="utf-8"))
names = {each["id"]: each["name"] for each in coco["categories"]}
boxes = defaultdict(list)
for each in coco["annotations"]:
    boxes[each["image_id"]].append((each["bbox"], names[each["category_id"]]))

panels = []
for each in coco["images"]:
    picture = Image.open(dataset / "train" / each["file_name"]).convert("RGB")
    pen = ImageDraw.Draw(picture)
    for (left, top, width, height), name in boxes[each["id"]]:
        pen.rectangle((left, top, left + width - 1, top + height - 1), outline=(0, 255, 60))
        place = (max(left, 0) + 1, max(top - 11, 0))
        pen.rectangle(pen.textbbox(place, name), fill=(0, 255, 60))
        pen.text(place, name, fill="black")
    panels.append(np.asarray(picture))
rows = np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])])
Image.fromarray(rows).save("job_detection.png", optimize=True)
