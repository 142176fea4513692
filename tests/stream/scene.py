"""A Replicator script with physics, draws, a writer, and a picture that it reads itself."""

import asyncio
import os
import sys

import omni.replicator.core as rep
import omni.timeline

frames = int(sys.argv[1])
with rep.new_layer():
    ball = rep.create.sphere(position=(0, 0, 3), semantics=[("class", "ball")])
    cube = rep.create.cube(semantics=[("class", "cube")], scale=0.5)
    floor = rep.create.plane(scale=8)
    rep.create.light(light_type="dome", intensity=800)
    camera = rep.create.camera(position=(6, 6, 5), look_at=(0, 0, 1))
    product = rep.create.render_product(camera, (48, 32))
    with ball:
        rep.physics.rigid_body()
    with floor:
        rep.physics.collider()
    with rep.trigger.on_frame(max_execs=frames), cube:
        rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0.5), (2, 2, 0.5)))

writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("written"), rgb=True)
writer.attach(product)
depth = rep.AnnotatorRegistry.get_annotator("distance_to_camera")
depth.attach(product)


async def main():
    for _ in range(frames):
        await rep.orchestrator.step_async(delta_time=0.1)
        # Its own pictures are rendered for every frame.
        assert depth.get_data().shape == (32, 48)
    await rep.orchestrator.wait_until_complete_async()
    if "--fail" in sys.argv:
        raise ValueError("the script failed")


omni.timeline.get_timeline_interface().play()
asyncio.ensure_future(main())  # noqa: RUF006 - as users write it
