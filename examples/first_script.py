"""A first Replicator script, as it would run in Omniverse: toys at random poses around a cube in every frame.

    usdsdg run examples/first_script.py [--out FOLDER] [--width PIXELS] [--frames N]

Shows a new layer, a registered randomizer, a trigger and BasicWriter. Writes images with boxes, masks and depths to
FOLDER (_out/first_script). The cube does not move, so its box is the same in every frame.
"""

import argparse
import os

import omni.replicator.core as rep

parser = argparse.ArgumentParser()
parser.add_argument("--out", default="_out/first_script")
parser.add_argument("--width", type=int, default=320)
parser.add_argument("--frames", type=int, default=6)
args, _ = parser.parse_known_args()

with rep.new_layer():
    grass = rep.create.material_omnipbr(diffuse=(0.10, 0.22, 0.07), roughness=0.9)
    rep.create.plane(scale=40, semantics=[("class", "floor")], material=grass)
    red = rep.create.material_omnipbr(diffuse=(0.55, 0.06, 0.04), roughness=0.4)
    rep.create.cube(position=(0, 0, 0.5), semantics=[("class", "cube")], material=red)
    rep.create.light(light_type="Dome", intensity=450)
    rep.create.light(light_type="Distant", intensity=2500, rotation=(35, 25, 0))
    camera = rep.create.camera(position=(0, -5, 1.4), look_at=(0, 0, 1.4), clipping_range=(0.1, 100))
    product = rep.create.render_product(camera, (args.width, args.width * 9 // 16))

    def throw_toys():
        toys = rep.create.group(
            [
                rep.create.sphere(semantics=[("class", "ball")], count=6),
                rep.create.cone(semantics=[("class", "cone")], count=6),
                rep.create.torus(semantics=[("class", "ring")], count=6),
            ]
        )
        with toys:
            rep.modify.pose(
                position=rep.distribution.uniform((-5, 1.5, 0.4), (5, 8, 3)),
                rotation=rep.distribution.uniform((0, 0, 0), (360, 360, 360)),
                scale=rep.distribution.uniform(0.5, 1.0),
            )
            rep.randomizer.color(colors=rep.distribution.uniform((0.1, 0.1, 0.1), (0.9, 0.9, 0.9)))
        return toys.node

    rep.randomizer.register(throw_toys)
    with rep.trigger.on_frame(max_execs=args.frames, rt_subframes=16):
        rep.randomizer.throw_toys()

writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(
    output_dir=os.path.abspath(args.out), rgb=True, bounding_box_2d_tight=True, semantic_segmentation=True,
    distance_to_image_plane=True,
)  # fmt: skip
writer.attach([product])
rep.orchestrator.run()
