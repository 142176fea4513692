"""Scattering, instances, orbits, materials and projections of a saved stage continue as in the script."""

import pytest

import usdsdg as rep
from usdsdg.app import saved_graph
from usdsdg.graph import evaluate
from usdsdg.session import stage_context

pytestmark = pytest.mark.usefixtures("stage")


def build():
    """Create a trigger with one randomizer of each kind."""
    floor, box = rep.create.plane(scale=4), rep.create.cube(scale=3)
    balls = rep.create.sphere(count=5, scale=0.2)
    cones = rep.create.cone(count=3, scale=0.2)
    camera = rep.create.camera()
    product = rep.create.render_product(camera, (64, 48))
    with rep.trigger.on_custom_event("go"):
        rep.randomizer.scatter_2d(floor, max_samp=(1, None, None), check_for_collisions=True, input_prims=balls)
        rep.randomizer.scatter_3d(box, no_coll_prims=balls, input_prims=cones)
        toys = rep.randomizer.instantiate(cones, size=4, weights=[1, 2, 1])
        with toys:
            rep.modify.pose(position_x=rep.distribution.uniform(0, 1), pivot=(0, 0, -1), rotation_z=[1, 2, 3, 4])
        rep.randomizer.instantiate(cones, size=rep.distribution.choice([1, 3]))
        rep.modify.pose_orbit((0, 0, 0), 5, rep.distribution.uniform(0, 360), 30, input_prims=camera)
        rep.modify.pose_camera_relative(camera, product, 2.0, input_prims=floor)
        rep.create.material_omnipbr(roughness=rep.distribution.uniform(0, 1))
        rep.create.projection_material(cones.prims[0], input_prims=floor)
        rep.modify.time(rep.distribution.uniform(0, 1))
        rep.physics.physics_material(restitution=rep.distribution.uniform(0, 1), input_prims=box)


def fired(times):
    stage = stage_context.current_stage()
    for _ in range(times):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
    return {
        str(attribute.GetPath()): str(attribute.Get())
        for prim in stage.Traverse()
        if not str(prim.GetPath()).startswith("/Replicator/SDGPipeline")
        for attribute in prim.GetAuthoredAttributes()
    }


def test_a_saved_graph_continues_as_the_script_would(tmp_path):
    stage_context.new_stage()
    rep.set_global_seed(11)
    build()
    evaluate.graph().evaluate()
    path = stage_context.save_stage(tmp_path / "scene.usda")
    expected = fired(2)
    stage_context.open_stage(path)
    saved_graph.load(stage_context.current_stage())
    found = fired(2)
    assert set(found) == set(expected)
    different = [name for name in expected if found[name] != expected[name]]
    assert different == []
