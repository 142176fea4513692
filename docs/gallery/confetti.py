"""Two thousand pieces, each with a place, an orientation and a color of its own, drawn by three randomizers."""

import os

from PIL import Image

import usdsdg as rep

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 48))
PIECES = int(os.environ.get("PARTS", 500))
PALETTE = [(0.93, 0.34, 0.18), (0.95, 0.71, 0.24), (0.16, 0.45, 0.52), (0.90, 0.87, 0.78), (0.13, 0.20, 0.31)]
rep.set_global_seed(12)
rep.settings.set_render_pathtraced(SAMPLES)
rep.create.light(light_type="Dome", intensity=500)
rep.create.light(light_type="Distant", intensity=2500, rotation=(30, 35, 0))
rep.create.plane(position=(0, 6, 0), rotation=(90, 0, 0), scale=60)
looks = [rep.create.material_omnipbr(diffuse=color, roughness=0.5) for color in PALETTE]
for make in (rep.create.cube, rep.create.sphere, rep.create.cone, rep.create.torus):
    pieces = make(count=PIECES, scale=0.22)
    with pieces:
        rep.modify.pose(position=rep.distribution.normal((0, 0, 0), (2.0, 1.4, 1.1)))
        rep.randomizer.rotation()
        rep.randomizer.materials(looks)
camera = rep.create.camera(position=(0, -11, 0), look_at=(0, 0, 0), focal_length=30, clipping_range=(0.1, 100))
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH * 9 // 16)))
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("confetti.png", optimize=True)
