"""Groceries on a table: demo assets under a photographed kind of sky, path traced.

The assets and the sky are made by code; with `--assets-root`, or the variable USDSDG_ASSETS_ROOT, they are yours.
"""

import os

from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 48))
YCB = "/Isaac/Props/YCB/Axis_Aligned"
GROCERIES = {
    "003_cracker_box": ((-0.16, 0.10, 0.107), 65),
    "006_mustard_bottle": ((0.13, 0.12, 0.095), 10),
    "005_tomato_soup_can": ((0.00, 0.00, 0.051), -60),
    "004_sugar_box": ((0.02, 0.19, 0.088), 120),
    "011_banana": ((-0.11, -0.08, 0.018), -25),
    "010_potted_meat_can": ((0.13, -0.03, 0.041), 25),
    "008_pudding_box": ((0.24, 0.06, 0.019), 60),
}

rep.settings.set_render_pathtraced(SAMPLES)
sky = "/NVIDIA/Assets/Skies/Indoor/wooden_lounge_4k.hdr"
rep.create.light(light_type="Dome", texture=sky, intensity=1100, rotation=(0, 0, 60))
rep.create.light(light_type="Rect", position=(-0.7, -0.5, 1.1), look_at=(0, 0, 0), scale=0.5, intensity=14000)
wood = rep.create.material_omnipbr(diffuse=(0.20, 0.10, 0.05), roughness=0.35)
rep.create.cube(position=(0, 0, -0.02), scale=(1.4, 0.9, 0.04), material=wood)
for name, (position, turn) in GROCERIES.items():
    rep.create.from_usd(f"{YCB}/{name}.usd", position=position, rotation=(0, 0, turn))
camera = rep.create.camera(
    position=(0.12, -0.95, 0.36), look_at=(0.03, 0.05, 0.075), focal_length=38, clipping_range=(0.01, 100),
    f_stop=900, focus_distance=0.95,
)  # fmt: skip
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH * 2 // 3)))
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("groceries.png", optimize=True)
