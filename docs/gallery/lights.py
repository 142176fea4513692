"""Lights of UsdLux in a closed room: a rectangle, a sphere and a cylinder, with their soft shadows."""

import os

from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 16))
rep.settings.set_render_pathtraced(SAMPLES)
wall = rep.create.material_omnipbr(diffuse=(0.72, 0.70, 0.67), roughness=0.9)
for position, scale in (
    ((0, 0, -0.05), (6, 5, 0.1)), ((0, 0, 3.05), (6, 5, 0.1)), ((0, 2.5, 1.5), (6, 0.1, 3)),
    ((-3, 0, 1.5), (0.1, 5, 3)), ((3, 0, 1.5), (0.1, 5, 3)),
):  # fmt: skip
    rep.create.cube(position=position, scale=scale, material=wall)
clay = rep.create.material_omnipbr(diffuse=(0.6, 0.58, 0.55), roughness=0.6)
rep.create.torus(position=(-1.2, 0.5, 0.55), rotation=(60, 0, 30), scale=1.1, material=clay)
rep.create.sphere(position=(0.2, -0.3, 0.55), scale=1.1, material=clay)
rep.create.cone(position=(1.5, 0.6, 0.6), scale=1.2, material=clay)
rep.create.light(light_type="Rect", position=(0.4, -1.2, 2.95), scale=(1.6, 0.5, 1), intensity=14000)
rep.create.light(light_type="Sphere", position=(-2.5, 1.7, 0.6), scale=0.35, intensity=32000, color=(1.0, 0.42, 0.12))
rep.create.light(
    light_type="Cylinder", position=(2.75, 0.8, 1.4), rotation=(0, 90, 0), scale=(1.6, 0.12, 0.12), intensity=42000,
    color=(0.2, 0.5, 1.0),
)  # fmt: skip
camera = rep.create.camera(position=(0, -6.4, 1.6), look_at=(0, 0, 1.15), focal_length=24, clipping_range=(0.1, 100))
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH * 9 // 16)))
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("lights.png", optimize=True)
