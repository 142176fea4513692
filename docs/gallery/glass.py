"""Glass, gold and porcelain under a sky: many bounces of light, refraction and depth of field."""

import os

from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 16))
rep.settings.set_render_pathtraced(SAMPLES)
sky = "/NVIDIA/Assets/Skies/Indoor/autoshop_01_4k.hdr"
rep.create.light(light_type="Dome", texture=sky, intensity=900, rotation=(0, 0, 200))
floor = rep.create.material_omnipbr(diffuse=(0.32, 0.34, 0.36), roughness=0.5)
rep.create.plane(scale=40, material=floor)

glass = rep.functional.create.material("OmniGlass.mdl", glass_color=(0.95, 0.99, 1.0), glass_ior=1.5)
gold = rep.create.material_omnipbr(diffuse=(1.0, 0.70, 0.28), metallic=1.0, roughness=0.15)
porcelain = rep.create.material_omnipbr(diffuse=(0.85, 0.83, 0.78), roughness=0.12)
lacquer = rep.create.material_omnipbr(diffuse=(0.45, 0.03, 0.03), roughness=0.2)
rep.create.sphere(position=(-1.15, -0.2, 0.5), material=gold)
rep.create.sphere(position=(0, -0.6, 0.5), material=glass)
rep.create.sphere(position=(1.1, 0.1, 0.5), material=porcelain)
rep.create.torus(position=(0.3, 1.2, 0.5), rotation=(75, 0, 20), scale=1.0, material=lacquer)
rep.create.cube(position=(-0.7, 1.5, 0.4), rotation=(0, 0, 30), scale=0.8, material=glass)

camera = rep.create.camera(
    position=(0.6, -5.2, 1.5), look_at=(0, 0, 0.45), focal_length=38, clipping_range=(0.1, 1000),
    f_stop=260, focus_distance=4.7,
)  # fmt: skip
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH * 9 // 16)))
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("glass.png", optimize=True)
