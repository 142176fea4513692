"""Machine parts that were dropped into a bin and came to rest: what the job of bin picking does, in a script."""

import os
from pathlib import Path

from PIL import Image
from pxr import UsdShade

import usdsdg as rep
from usdsdg import demo

WIDTH, SAMPLES = int(os.environ.get("WIDTH", 480)), int(os.environ.get("SAMPLES", 16))
PARTS = int(os.environ.get("PARTS", 8))
rep.set_global_seed(2)
rep.orchestrator.set_capture_on_play(False)  # frames do not play the timeline
rep.settings.set_render_pathtraced(SAMPLES)
blue = rep.create.material_omnipbr(diffuse=(0.03, 0.14, 0.32), roughness=0.4)
sides = [((0, 0, -0.005), (0.36, 0.27, 0.01))]
sides += [((side * 0.18, 0, 0.05), (0.008, 0.27, 0.12)) for side in (-1, 1)]
sides += [((0, side * 0.135, 0.05), (0.36, 0.008, 0.12)) for side in (-1, 1)]
box = [rep.create.cube(position=position, scale=scale, material=blue) for position, scale in sides]
table = rep.create.cube(position=(0, 0, -0.06), scale=(3, 3, 0.1))
rep.physics.collider(input_prims=rep.create.group([*box, table]))

looks = [
    rep.create.material_omnipbr(diffuse=color, metallic=metallic, roughness=0.35)
    for color, metallic in (((0.75, 0.75, 0.77), 1.0), ((0.85, 0.55, 0.25), 1.0), ((0.62, 0.08, 0.05), 0.0))
]
parts = []
for level, file in enumerate(sorted(Path(demo.machine_parts()).glob("*.usd"))):
    some = rep.create.from_usd(str(file), count=PARTS, semantics=[("class", file.stem)])
    for prim in rep.get.prims(path_pattern="/Ref(_[0-9]+)?(/|$)").get_output_prims()["prims"]:
        # Materials of the file would win over those that are drawn for a whole part.
        UsdShade.MaterialBindingAPI(prim).UnbindAllBindings()
    with some:
        rep.randomizer.scatter_3d(
            min_samp=(-0.12, -0.08, 0.08 + 0.09 * level), max_samp=(0.12, 0.08, 0.15 + 0.09 * level),
            check_for_collisions=True,
        )  # fmt: skip
        rep.randomizer.rotation()
        rep.randomizer.materials(looks)
    parts.append(some)
everything = rep.create.group(parts)
rep.physics.rigid_body(input_prims=everything)
with rep.trigger.on_custom_event("drop"):
    rep.physics.simulate_until_rest(max_time=6.0)

rep.create.light(light_type="Dome", intensity=250)
rep.create.light(light_type="Rect", position=(-0.6, -0.3, 1.0), look_at=(0, 0, 0), scale=0.5, intensity=14000)
camera = rep.create.camera(
    position=(0.10, -0.36, 0.44), look_at=(0, 0, 0.03), focal_length=32, clipping_range=(0.01, 9)
)
picture = rep.annotators.get("rgb").attach(rep.create.render_product(camera, (WIDTH, WIDTH * 3 // 4)))
rep.orchestrator.step()
rep.utils.send_og_event("drop")
rep.orchestrator.step()
Image.fromarray(picture.get_data()[..., :3]).save("bin.png", optimize=True)
