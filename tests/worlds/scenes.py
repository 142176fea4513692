"""Scenes that worlds can draw, each of other randomizers, and what their frames and their worlds show."""

import numpy as np

import usdsdg as rep
from usdsdg.capture.worlds import WorldTap
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage

SIZE = (40, 30)
NAMES = ("rgb", "distance_to_camera", "semantic_segmentation", "instance_segmentation", "bounding_box_2d_tight")
uniform, choice = rep.distribution.uniform, rep.distribution.choice


def poses_and_colors():
    """Poses and colors of shapes, under a dome and a fixed camera."""
    rep.create.light(light_type="dome", intensity=1000)
    shapes = rep.create.cube(count=4, semantics=[("class", "cube")])
    others = rep.create.torus(count=2, semantics=[("class", "torus")])
    rep.create.plane(scale=10, position=(0, 0, -2))
    with rep.trigger.on_frame():
        with shapes:
            rep.modify.pose(position=uniform((-2, -2, -1), (2, 2, 2)), rotation=uniform((0, 0, 0), (360, 360, 360)))
            rep.randomizer.color(colors=uniform((0, 0, 0), (1, 1, 1)))
        with others:
            rep.randomizer.rotation()
            rep.modify.pose(position=rep.distribution.combine([uniform(-2, 2), 0.5, rep.distribution.normal(0, 1)]))
            rep.modify.visibility()
    return rep.create.camera(position=(7, 1, 3), look_at=(0, 0, 0))


def cameras_and_lights():
    """A camera that looks at a moving object, and lights of other brightness, color and direction; an interval."""
    dome = rep.create.light(light_type="dome", intensity=300)
    sun = rep.create.light(light_type="distant", intensity=1000)
    lamp = rep.create.light(light_type="sphere", intensity=20000, position=(0, 2, 3), scale=0.5)
    ball = rep.create.sphere(semantics=[("class", "ball")])
    rep.create.cube(position=(0, 2, 0), semantics=[("class", "cube")])
    rep.create.plane(scale=10, position=(0, 0, -1))
    camera = rep.create.camera(position=(7, 1, 3))
    with rep.trigger.on_frame(interval=2):
        with dome:
            rep.modify.attribute("intensity", uniform(100, 500))
            rep.modify.pose(rotation=uniform((0, 0, 0), (0, 0, 360)))
        with sun:
            rep.modify.attribute("color", uniform((0.5, 0.5, 0.5), (1, 1, 1)))
            rep.modify.pose(rotation=uniform((-60, -30, 0), (-30, 30, 0)))
    with rep.trigger.on_frame():
        with ball:
            rep.modify.pose(position_z=uniform(-1, 1), scale=uniform(0.5, 1.5))
        with camera:
            rep.modify.pose(
                position=uniform((6, -2, 1), (8, 2, 4)), look_at=str(ball.get_output_prims()["prims"][0].GetPath())
            )
        with lamp:
            rep.modify.pose(position=choice([(0, 2, 3), (2, -2, 3)]))
            rep.modify.attribute("intensity", choice([0.0, 10000.0, 30000.0]))
    return camera


def materials_and_lists():
    """Inputs of materials, display colors, choices and sequences, and sizes."""
    rep.create.light(light_type="dome", intensity=800)
    steel = rep.create.material_omnipbr(diffuse=(0.5, 0.5, 0.6), metallic=0.2, roughness=0.3)
    bodies = rep.create.sphere(count=3, material=steel, semantics=[("class", "ball")])
    blocks = rep.create.cube(count=2, semantics=[("class", "cube")])
    shader = f"{steel.prims[0]}/Shader"
    with rep.trigger.on_frame(max_execs=4):
        rep.modify.attribute("inputs:reflection_roughness_constant", uniform(0, 1), input_prims=shader)
        rep.modify.attribute("inputs:metallic_constant", choice([0.0, 1.0]), input_prims=shader)
        with bodies:
            rep.modify.pose(position=rep.distribution.sequence([(0, -2, 0), (0, 0, 0), (0, 2, 0), (0, 0, 2)]))
        with blocks:
            rep.modify.attribute("primvars:displayColor", uniform((0, 0, 0), (1, 1, 1)))
            rep.modify.pose(
                scale=uniform(0.5, 1.5), rotation_z=uniform(0, 90), position=uniform((1, -3, -2), (2, 3, -1))
            )
    return rep.create.camera(position=(9, 0, 2), look_at=(0, 0, 0))


def orbits_and_nested_prims():
    """A camera on an orbit around a prim that moves, shapes below a group that moves, and single axes of rotation."""
    rep.create.light(light_type="dome", intensity=800)
    ball = rep.create.sphere(semantics=[("class", "ball")])
    cubes = rep.create.cube(count=2, position=(0, 1.5, 0), semantics=[("class", "cube")])
    group = rep.create.group([ball, cubes])
    camera = rep.create.camera()
    with rep.trigger.on_frame():
        with group:
            rep.modify.pose(rotation_x=uniform(0, 90), rotation_order="ZYX")
        with ball:
            rep.modify.pose(position=uniform((-1, -1, -1), (1, 1, 1)))
        with cubes:
            rep.modify.pose(look_at=ball, position=uniform((-2, 1, -1), (2, 3, 1)))
        with camera:
            rep.modify.pose_orbit(barycentre=ball, distance=uniform(5, 8), azimuth=uniform(0, 360), elevation=30)
    return camera


def other_intervals():
    """Attributes that triggers of different intervals write, and a camera that looks where a shape was before."""
    rep.create.light(light_type="dome", intensity=800)
    sun = rep.create.light(light_type="distant", intensity=500)
    ball = rep.create.sphere(semantics=[("class", "ball")], scale=0.4)
    cubes = rep.create.cube(count=2, scale=0.3, semantics=[("class", "cube")])
    camera = rep.create.camera(position=(6, 0, 2))
    with rep.trigger.on_frame(), camera:
        rep.modify.pose(position=uniform((5, -1, 1), (7, 1, 3)), look_at=ball)
    with rep.trigger.on_frame():
        with ball:
            rep.modify.pose(position=uniform((-1, -1, -1), (1, 1, 1)))
        with cubes:
            rep.modify.pose(position=uniform((-1, -2, -1), (1, 2, 1)), rotation=uniform((0, 0, 0), (90, 90, 90)))
        with sun:
            rep.modify.pose(rotation=uniform((-60, 0, 0), (60, 0, 0)))
    with rep.trigger.on_frame(interval=2), cubes:
        rep.modify.pose(position_z=1.5, rotation_x=choice([0.0, 90.0]))
        rep.modify.visibility(choice([True, False]))
    with rep.trigger.on_frame(max_execs=2), ball:
        rep.modify.attribute("xformOp:scale", uniform((0.3, 0.3, 0.3), (0.6, 0.6, 0.6)))
    with rep.trigger.on_frame(interval=3), ball:
        rep.modify.pose(scale=uniform(0.3, 0.6))
    return camera


def draws_of_several_nodes():
    """Poses, colors and parts of vectors that take one distribution."""
    camera = rep.create.camera(position=(0, 0, 9), look_at=(0, 0, 0))
    rep.create.light(light_type="dome")
    boxes = rep.create.cube(count=2, semantics=[("class", "box")], scale=0.4)
    balls = rep.create.sphere(count=3, semantics=[("class", "ball")], scale=0.4)
    with rep.trigger.on_frame():
        place, shade = uniform((-3, -2, -1), (3, 2, 1)), rep.distribution.choice([0.2, 0.5, 0.9])
        with boxes:
            rep.modify.pose(position=place)
            rep.randomizer.color(rep.distribution.combine([shade, uniform(0, 1), shade]))
        with balls:
            rep.modify.pose(position=place, scale=shade)
    return camera


def scattered():
    """Shapes on a floor and in volumes, of which one moves, with rotations of their own."""
    rep.create.light(light_type="dome", intensity=800)
    floor = rep.create.plane(scale=4, rotation=(20, 0, 30))
    room = rep.create.sphere(scale=1.5, position=(0, 0, 2), visible=False)
    cubes = rep.create.cube(count=3, scale=0.4, semantics=[("class", "cube")])
    balls = rep.create.sphere(count=2, scale=0.3, semantics=[("class", "ball")])
    cones = rep.create.cone(count=2, scale=0.3, semantics=[("class", "cone")])
    with rep.trigger.on_frame():
        with room:
            rep.modify.pose(position=uniform((-1, -1, 1), (1, 1, 3)))
        with cubes:
            rep.modify.pose(rotation=uniform((0, 0, 0), (360, 360, 360)))
            rep.randomizer.scatter_2d(floor, offset=0.3)
        with balls:
            rep.randomizer.scatter_3d(room)
    with rep.trigger.on_frame(interval=2), cones:
        rep.randomizer.scatter_3d(min_samp=(-2, -2, 0), max_samp=(2, 2, 2), seed=3)
    return rep.create.camera(position=(8, 1, 5), look_at=(0, 0, 0))


def scattered_without_collisions():
    """Shapes that turn and grow, on a floor that tilts, among obstacles that move."""
    rep.create.light(light_type="dome", intensity=800)
    floor = rep.create.plane(scale=3)
    posts = rep.create.cylinder(count=2, scale=0.5)
    group = rep.create.group([rep.create.torus(scale=0.4), rep.create.torus(scale=0.4, position=(1, 1, 0))])
    cubes = rep.create.cube(count=5, scale=0.4, semantics=[("class", "cube")])
    with rep.trigger.on_frame():
        with floor:
            rep.modify.pose(rotation_x=uniform(-30, 30))
        with posts:
            rep.modify.pose(position=uniform((-1, -1, 0), (1, 1, 0)))
        with group:
            rep.modify.pose(rotation_z=uniform(0, 90))
        with cubes:
            rep.modify.pose(rotation=uniform((0, 0, 0), (90, 90, 90)), scale=uniform(0.3, 0.6))
            rep.randomizer.scatter_2d(floor, no_coll_prims=[posts, group], check_for_collisions=True)
    return rep.create.camera(position=(8, 1, 5), look_at=(0, 0, 0))


def begin(build):
    """Open a new stage with a scene; return its render product."""
    session.restart()
    rep.set_global_seed(5)
    new_stage()
    return rep.create.render_product(build(), SIZE)


def frames_of(build, count):
    """What annotators give of so many frames of a scene, one by one."""
    product = begin(build)
    annotators = {
        name: rep.annotators.get(name, init_params={"colorize": False} if "segmentation" in name else None).attach(
            product
        )
        for name in NAMES
    }
    found = []
    for _ in range(count):
        rep.orchestrator.step()
        found.append({name: annotator.get_data() for name, annotator in annotators.items()})
    return found


def worlds_of(build, count, steps=1, names=NAMES):
    """The batches of so many steps of a scene, of `count` worlds each."""
    begin(build)
    batches = []
    session.current().worlds = WorldTap(count, names, batches.append)
    for _ in range(steps):
        rep.orchestrator.step()
    return batches


def plain(data):
    """The array of what `get_data` returns."""
    return np.asarray(data["data"] if isinstance(data, dict) else data)


def boxes_of(frame):
    """By prim path, the box of `bounding_box_2d_tight`."""
    found = frame["bounding_box_2d_tight"]
    rows = found["data"]
    names = [f"{each}_{corner}" for corner in ("min", "max") for each in "xy"]
    return {path: [int(row[name]) for name in names] for path, row in zip(found["info"]["primPaths"], rows)}


def compared(build, count, steps):
    """Compare worlds with the frames of their numbers; return the bytes of the pictures.

    Raises:
        AssertionError: they differ.
    """
    frames = frames_of(build, count * steps)
    batches = worlds_of(build, count, steps)
    assert [batch.frame for batch in batches] == [count * step for step in range(steps)]
    pictures = []
    for batch in batches:
        arrays = {name: array.numpy() for name, array in batch.arrays.items()}
        for world in range(count):
            frame = frames[batch.frame + world]
            for name in set(NAMES) - {"bounding_box_2d_tight"}:
                message = f"{name} of frame {batch.frame + world}"
                np.testing.assert_array_equal(arrays[name][world], plain(frame[name]), err_msg=message)
            boxes = dict(zip(batch.prims, arrays["bounding_box_2d_tight"][world].tolist()))
            assert {path: box[1:] for path, box in boxes.items() if box[0] > 0} == boxes_of(frame)
            assert all(box == [0, -1, -1, -1, -1] for box in boxes.values() if box[0] == 0)
            pictures.append(arrays["rgb"][world].tobytes())
    return pictures
