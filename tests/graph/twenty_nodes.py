"""A Replicator script with a node of every kind that a saved stage can hold; its argument is the output folder."""

import sys

import carb
import omni.replicator.core as rep

rep.set_global_seed(3)
carb.settings.get_settings().set("/omni/replicator/RTSubframes", 2)
rep.create.light(light_type="Dome", intensity=800)
rep.create.plane(scale=6, semantics=[("class", "floor")])
cubes = rep.create.cube(count=4, semantics=[("class", "cube")])
balls = rep.create.sphere(count=3, semantics=[("class", "ball")])
draw = rep.distribution
with rep.trigger.on_frame():
    with cubes:
        rep.modify.pose(
            position=draw.uniform((-1, -1, 0), (1, 1, 1)),
            rotation=draw.normal((0, 0, 0), (30, 30, 90)),
            scale=draw.uniform(0.1, 0.5),
        )
        rep.randomizer.color(colors=draw.uniform((0, 0, 0), (1, 1, 1)))
        rep.modify.visibility(draw.choice([True, True, False], seed=7))
        # Both, since the saved stage goes on with the velocities of the last frame.
        rep.physics.rigid_body(
            velocity=draw.uniform((-1, -1, -1), (1, 1, 1)), angular_velocity=draw.uniform((-90, -90, -90), (90, 90, 90))
        )
    with balls:
        rep.modify.pose(
            position=draw.combine([draw.uniform(-1, 1), draw.log_uniform(0.1, 1.0), 0.4]),
            look_at=draw.choice([(0, 0, 0), (1, 1, 1)]),
        )
        rep.randomizer.color(colors=[(1, 0, 0), (0, 1, 0), (0, 0, 1)])
        rep.randomizer.rotation()
        rep.modify.attribute("visibility", draw.sequence(["inherited", "invisible"]))
with rep.trigger.on_frame(interval=2, max_execs=3):
    rep.create.light(
        light_type="Sphere",
        color=draw.uniform((0, 0, 0), (1, 1, 1)),
        intensity=draw.normal(30000, 5000),
        position=draw.uniform((-3, -3, 1), (3, 3, 4)),
        count=2,
    )
with rep.trigger.on_custom_event("go"), cubes:
    rep.modify.pose(position=(0, 0, 1))
camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0), clipping_range=(0.1, 100))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True, bounding_box_2d_tight=True, semantic_segmentation=True)
writer.attach(rep.create.render_product(camera, (160, 120)))
rep.orchestrator.run(num_frames=4)
rep.orchestrator.wait_until_complete()
