"""Materials: roughness grows from left to right, from a plastic above to a metal below."""

import os

from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 16))
rep.settings.set_render_pathtraced(SAMPLES)
sky = "/NVIDIA/Assets/Skies/Indoor/hotel_room_4k.hdr"
rep.create.light(light_type="Dome", texture=sky, intensity=800, rotation=(0, 0, 30))
rep.create.light(light_type="Rect", position=(-3, -5, 5), look_at=(0, 0, 0), scale=2.5, intensity=6000)
rep.create.plane(position=(0, 1.2, 0), rotation=(90, 0, 0), scale=20)
rows = [((0.05, 0.28, 0.42), 0.0), ((0.55, 0.30, 0.24), 0.5), ((0.95, 0.64, 0.54), 1.0)]
for row, (color, metallic) in enumerate(rows):
    for column in range(6):
        material = rep.create.material_omnipbr(diffuse=color, metallic=metallic, roughness=0.04 + 0.18 * column)
        rep.create.sphere(position=(1.1 * (column - 2.5), 0, 1.1 * (1 - row)), material=material)
camera = rep.create.camera(position=(0, -9.2, 0), look_at=(0, 0, 0), focal_length=28, clipping_range=(0.1, 100))
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH // 2)))
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("materials.png", optimize=True)
