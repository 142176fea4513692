"""One filling of the bin of configs/bin_picking.yaml from three cameras, over the masks of the visible parts."""

import os
from pathlib import Path

import numpy as np
from PIL import Image

from usdsdg.scenarios.jobs import load_job

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 810)) // 3, int(os.environ.get("SAMPLES", 32))
PARTS = int(os.environ.get("PARTS", 40))
CONFIG = Path(__file__).resolve().parents[2] / "configs" / "bin_picking.yaml"

settings = {
    "output_dir": "job_bin_picking",
    "formats": "{bop: {}}",
    "splits": "{train_pbr: 1}",
    "drops": 1,
    "frames_per_drop": 1,
    "parts.per_bin": f"[{PARTS}, {PARTS}]",
    "resolution": f"[{WIDTH}, {WIDTH * 3 // 4}]",
    "rendering.samples": SAMPLES,
    "seed": 5,
}
job, config = load_job(CONFIG, [f"{key}={value}" for key, value in settings.items()])
job.run(config)

colors = np.random.default_rng(2).uniform(60, 255, (PARTS, 3))
pictures, masked = [], []
for scene in sorted((Path("job_bin_picking") / "bop" / "train_pbr").iterdir()):
    rgb = np.asarray(Image.open(scene / "rgb" / "000000.png").convert("RGB"))
    shown = rgb * 0.4
    for file in sorted((scene / "mask_visib").glob("000000_*.png")):
        shown[np.asarray(Image.open(file)) > 0] = colors[int(file.stem[-6:])]
    pictures.append(rgb)
    masked.append(shown.astype(np.uint8))
rows = np.vstack([np.hstack(pictures), np.hstack(masked)])
Image.fromarray(rows).save("job_bin_picking.png", optimize=True)
