"""One frame and its labels: color, instances, normals and distance, side by side.

All of them are of the same pixels: masks, normals and depth come from one ray through the center of each.
"""

import os

import numpy as np
from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 48))
rep.set_global_seed(11)
rep.settings.set_render_pathtraced(SAMPLES)
rep.create.light(light_type="Dome", intensity=450)
rep.create.light(light_type="Distant", intensity=2200, rotation=(38, 22, 0))
rep.create.plane(scale=30, material=rep.create.material_omnipbr(diffuse=(0.55, 0.53, 0.5), roughness=0.8))
toys = rep.create.group(
    [
        make(count=5, scale=0.7, semantics=[("class", name)])
        for name, make in (("ball", rep.create.sphere), ("ring", rep.create.torus), ("block", rep.create.cube))
    ]
)
with rep.trigger.on_frame(), toys:
    rep.randomizer.scatter_3d(min_samp=(-2.2, -1.6, 0.4), max_samp=(2.2, 2.0, 1.3), check_for_collisions=True)
    rep.randomizer.rotation()
    rep.randomizer.color(
        colors=rep.distribution.choice([(0.75, 0.22, 0.10), (0.85, 0.60, 0.15), (0.10, 0.35, 0.45), (0.75, 0.72, 0.65)])
    )
camera = rep.create.camera(position=(0, -7, 3.4), look_at=(0, 0.1, 0.6), focal_length=30, clipping_range=(0.1, 100))
view = rep.create.render_product(camera, (WIDTH // 2, WIDTH // 3))
NAMES = ("rgb", "instance_segmentation", "normals", "distance_to_camera")
seen = {name: rep.annotators.get(name).attach(view) for name in NAMES}
rep.orchestrator.step()
data = {name: annotator.get_data() for name, annotator in seen.items()}

ids = data["instance_segmentation"]["data"]
hues = np.random.default_rng(3).uniform(60, 255, (int(ids.max()) + 1, 3))
hues[:2] = 25  # nothing, and what has no label
depth = data["distance_to_camera"]
near, far = depth.min(), np.percentile(depth, 90)
panels = [
    data["rgb"][..., :3],
    hues[ids],
    (data["normals"][..., :3] + 1) * 127.5,
    255 * np.clip((far - depth) / (far - near), 0, 1)[..., None].repeat(3, axis=-1),
]
rows = np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])])
Image.fromarray(rows.astype(np.uint8)).save("labels.png", optimize=True)
