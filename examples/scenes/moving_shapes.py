"""A Replicator script: shapes of five classes among distractors, all drawn anew in every frame.

Its arguments are the number of frames and the width of the square pictures. `train_live_detector.py` runs it as many
worlds; `usdsdg run examples/scenes/moving_shapes.py 8 320` writes a few of its frames.
"""

import os
import sys

import omni.replicator.core as rep

FRAMES, WIDTH = (int(argument) for argument in sys.argv[1:3])
PER_CLASS, DISTRACTORS = 3, 8
uniform = rep.distribution.uniform

with rep.new_layer():
    floor = rep.create.plane(scale=40, position=(0, 0, -2.5))
    rep.create.light(light_type="dome", intensity=700)
    sun = rep.create.light(light_type="distant", intensity=1500, rotation=(-50, 0, 0))
    makers = (rep.create.cube, rep.create.sphere, rep.create.cone, rep.create.cylinder, rep.create.torus)
    shapes = [make(count=PER_CLASS, semantics=[("class", make.__name__)]) for make in makers]
    distractors = [make(count=DISTRACTORS // 2) for make in (rep.create.cube, rep.create.sphere)]
    camera = rep.create.camera(position=(9, 0, 4), look_at=(0, 0, 0))
    product = rep.create.render_product(camera, (WIDTH, WIDTH))

    with rep.trigger.on_frame(max_execs=FRAMES):
        for group in shapes:
            with group:
                rep.modify.pose(
                    position=uniform((-3, -3, -2), (3, 3, 2)),
                    rotation=uniform((0, 0, 0), (360, 360, 360)),
                    scale=uniform(0.3, 0.7),
                )
                rep.randomizer.color(colors=uniform((0, 0, 0), (1, 1, 1)))
        for group in distractors:
            with group:
                rep.modify.pose(
                    position=uniform((-4, -4, -2), (4, 4, 2)), scale=uniform((0.1, 0.1, 0.1), (0.8, 0.3, 0.3))
                )
                rep.randomizer.color(colors=uniform((0, 0, 0), (1, 1, 1)))
                rep.modify.visibility()
        with floor:
            rep.randomizer.color(colors=uniform((0.1, 0.1, 0.1), (0.9, 0.9, 0.9)))
        with camera:
            rep.modify.pose(position=uniform((7, -5, 1), (10, 5, 6)), look_at=(0, 0, 0))
        with sun:
            rep.modify.attribute("intensity", uniform(500, 3000))
            rep.modify.pose(rotation=uniform((-80, -40, 0), (-30, 40, 360)))

writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("_out/moving_shapes"), rgb=True, bounding_box_2d_tight=True)
writer.attach(product)
rep.orchestrator.run()
