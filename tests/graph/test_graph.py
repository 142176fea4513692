"""When triggers fire, in which order nodes run, and that randomizers are independent."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdLux

from usdsdg import create, distribution, get, modify, randomizer, trigger, utils
from usdsdg.errors import GraphError, UsdsdgWarning
from usdsdg.graph import evaluate
from usdsdg.graph.sampling import set_global_seed
from usdsdg.randomizer.rotations import uniform_quaternions
from usdsdg.session.stage_context import new_stage


def cubes(stage, count=3):
    return [str(stage.DefinePrim(f"/World/cube_{i}", "Cube").GetPath()) for i in range(count)]


def sizes(stage, count=3):
    return [stage.GetPrimAtPath(f"/World/cube_{i}").GetAttribute("size").Get() for i in range(count)]


def randomize_sizes(stage, event="go"):
    with trigger.on_custom_event(event), create.group(cubes(stage)):
        modify.attribute("size", distribution.uniform(1.0, 2.0))


def test_an_event_fires_its_trigger_at_the_next_evaluation_only(stage):
    randomize_sizes(stage)
    evaluate.graph().evaluate()
    assert sizes(stage) == [2.0, 2.0, 2.0]
    utils.send_og_event("go")
    assert sizes(stage) == [2.0, 2.0, 2.0]
    evaluate.graph().evaluate()
    drawn = sizes(stage)
    assert len(set(drawn)) == 3
    evaluate.graph().evaluate()
    assert sizes(stage) == drawn


def test_an_event_sent_twice_fires_twice(stage):
    randomize_sizes(stage)
    utils.send_og_event("go")
    utils.send_og_event("go")
    assert len(evaluate.graph().evaluate()) == 2


def test_every_execution_draws_new_values_and_a_restart_repeats_them(stage):
    randomize_sizes(stage)
    runs = []
    for _ in range(2):
        for _ in range(2):
            utils.send_og_event("go")
            evaluate.graph().evaluate()
            runs.append(sizes(stage))
        evaluate.graph().restart()
    assert runs[0] != runs[1]
    assert runs[:2] == runs[2:]


def test_a_randomizer_added_before_does_not_change_draws_of_the_others(stage):
    def draw(with_extra):
        stage = new_stage()
        with trigger.on_custom_event("go"), create.group(cubes(stage)):
            if with_extra:
                randomizer.rotation()
            modify.attribute("size", distribution.uniform(1.0, 2.0))
        utils.send_og_event("go")
        evaluate.graph().evaluate()
        return sizes(stage)

    assert draw(False) == draw(True)


def test_on_frame_shows_the_preview_first_and_then_every_interval(stage):
    with trigger.on_frame(interval=2, max_execs=3), create.group(cubes(stage)):
        modify.attribute("size", distribution.uniform(1.0, 2.0))
    graph = evaluate.graph()
    graph.evaluate(preview=True)
    fired = [bool(graph.evaluate(capture=capture)) for capture in range(8)]
    assert fired == [False, False, True, False, True, False, False, False]


def test_an_event_sent_before_the_preview_still_fires(stage):
    randomize_sizes(stage)
    utils.send_og_event("go")
    evaluate.graph().evaluate(preview=True)
    assert sizes(stage) == [2.0, 2.0, 2.0]
    evaluate.graph().evaluate(capture=0)
    assert len(set(sizes(stage))) == 3


def test_an_integer_attribute_never_gets_the_upper_bound(stage):
    prims = cubes(stage, 200)
    for path in prims:
        stage.GetPrimAtPath(path).CreateAttribute("count", Sdf.ValueTypeNames.Int)
    modify.attribute("count", distribution.uniform(-1, 2), input_prims=prims)
    evaluate.graph().evaluate()
    assert {stage.GetPrimAtPath(path).GetAttribute("count").Get() for path in prims} == {-1, 0, 1}


def test_a_light_in_a_trigger_is_created_once_and_randomized_again(stage):
    with trigger.on_custom_event("lights"):
        create.light(
            light_type="Sphere",
            intensity=distribution.normal(35000, 5000),
            position=distribution.uniform((-1, -1, -1), (1, 1, 1)),
            scale=distribution.uniform(0.1, 1.0),
            count=3,
        )
    lights = [prim for prim in stage.Traverse() if prim.IsA(UsdLux.SphereLight)]
    assert [str(prim.GetPath()) for prim in lights] == [
        "/Replicator/SphereLight_Xform/SphereLight",
        "/Replicator/SphereLight_Xform_01/SphereLight",
        "/Replicator/SphereLight_Xform_02/SphereLight",
    ]
    seen = []
    for _ in range(2):
        utils.send_og_event("lights")
        evaluate.graph().evaluate()
        seen.append([prim.GetAttribute("inputs:intensity").Get() for prim in lights])
        scale = lights[0].GetParent().GetAttribute("xformOp:scale").Get()
        assert scale[0] == scale[1] == scale[2]
    assert len({*seen[0], *seen[1]}) == 6
    assert sum(prim.IsA(UsdLux.SphereLight) for prim in stage.Traverse()) == 3


def test_dome_textures_and_rotation_are_authored_on_the_light(stage, tmp_path):
    skies = [str(tmp_path / name) for name in ("a.hdr", "b.hdr")]
    for sky in skies:
        Path(sky).write_bytes(b"")
    with trigger.on_custom_event("dome"):
        dome = create.light(light_type="Dome")
        with dome:
            modify.attribute("inputs:texture:file", distribution.choice(skies))
            randomizer.rotation()
    utils.send_og_event("dome")
    evaluate.graph().evaluate()
    light = stage.GetPrimAtPath("/Replicator/DomeLight_Xform/DomeLight")
    assert light.GetAttribute("inputs:texture:file").Get().path in skies
    assert light.GetParent().GetAttribute("xformOp:rotateXYZ").Get() is not None


def test_randomized_colors_bind_one_material_per_prim_and_reuse_it(stage):
    with trigger.on_custom_event("paint"), create.group(cubes(stage)):
        randomizer.color(colors=distribution.uniform((0, 0, 0), (1, 1, 1)))
    counts = []
    for _ in range(2):
        utils.send_og_event("paint")
        evaluate.graph().evaluate()
        counts.append(sum(prim.GetTypeName() == "Material" for prim in stage.Traverse()))
    assert counts == [3, 3]
    color = stage.GetPrimAtPath("/Replicator/Looks/OmniPBR/Shader").GetAttribute("inputs:diffuse_color_constant").Get()
    twin = stage.GetPrimAtPath("/Replicator/Looks/OmniPBR/PreviewSurface").GetAttribute("inputs:diffuseColor").Get()
    assert color == twin


def colors_drawn(colors, seed=None):
    stage = new_stage()
    with trigger.on_custom_event("paint"), create.group(cubes(stage, 40)):
        randomizer.color(colors=colors, seed=seed)
    utils.send_og_event("paint")
    evaluate.graph().evaluate()
    looks = stage.GetPrimAtPath("/Replicator/Looks").GetChildren()
    return [tuple(look.GetChild("Shader").GetAttribute("inputs:diffuse_color_constant").Get()) for look in looks]


@pytest.mark.parametrize("as_given", [list, np.array])
def test_a_list_of_colors_is_chosen_from(stage, as_given):
    palette = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    drawn = colors_drawn(as_given(palette))
    assert set(drawn) == set(palette)
    # A choice, not the list in order, repeats an item.
    assert drawn != palette * 20
    assert set(colors_drawn([0.0, 0.5, 1.0])) == {(0.0, 0.5, 1.0)}


@pytest.mark.parametrize(
    "colors",
    [
        lambda: [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        lambda: distribution.uniform((0, 0, 0), (1, 1, 1)),
        lambda: distribution.combine([distribution.uniform(0, 1), 0.5, distribution.uniform(0, 1)]),
        lambda: distribution.choice([distribution.uniform((0, 0, 0), (1, 1, 1)), (1, 1, 1)]),
    ],
    ids=["list", "uniform", "combine", "choice"],
)
def test_a_color_randomizers_own_seed_replaces_the_global_one(stage, colors):
    first = colors_drawn(colors(), seed=7)
    assert colors_drawn(colors(), seed=8) != first
    set_global_seed(5)
    assert colors_drawn(colors(), seed=7) == first
    assert colors_drawn(colors()) == colors_drawn(colors(), seed=5)


def test_two_different_seeds_for_one_draw_are_an_error(stage):
    seeded = distribution.uniform((0, 0, 0), (1, 1, 1), seed=3)
    assert colors_drawn(seeded, seed=3) == colors_drawn(seeded)
    with pytest.raises(GraphError, match=r"seed=3.*seed=7"):
        colors_drawn(seeded, seed=7)


def test_random_rotations_are_uniform_on_so3(stage):
    quaternions = uniform_quaternions(np.random.default_rng(0).random((20000, 3)))
    assert np.allclose(np.linalg.norm(quaternions, axis=1), 1)
    # The squared components of a uniform quaternion are Dirichlet(1/2, ...): mean 1/4, E[w^4] = 1/8.
    assert np.allclose((quaternions**2).mean(0), 0.25, atol=0.01)
    assert np.allclose((quaternions**4).mean(0), 0.125, atol=0.01)


def test_a_camera_looks_at_its_target(stage):
    create.camera(position=(3, 0, 1), look_at=(0, 0, 0))
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/Replicator/Camera_Xform/Camera")).GetCamera(0)
    ray = camera.frustum.ComputeViewDirection()
    assert np.allclose(ray, np.array([-3, 0, -1]) / np.sqrt(10), atol=1e-6)
    up = camera.frustum.ComputeUpVector()
    assert up[2] > 0.9


def test_errors_name_the_script_line(stage):
    with trigger.on_custom_event("go"), create.group(cubes(stage)):
        modify.attribute("sise", 1.0)
    utils.send_og_event("go")
    with pytest.raises(GraphError, match=r"test_graph\.py:\d+.*no attribute 'sise'"):
        evaluate.graph().evaluate()


def test_a_script_whose_name_is_no_utf8_is_named_on_the_stage(stage):
    """A file's name may have any bytes; Python has those that are no UTF-8 as half characters, USD has none."""
    exec(compile("trigger.on_frame(name='every')", "/scripts/caf\udce9.py", "exec"), {"trigger": trigger})
    lines = [prim.GetAttribute("usdsdg:line").Get() for prim in stage.Traverse() if prim.HasAttribute("usdsdg:line")]
    assert lines == [r"caf\udce9.py:1"]


def test_acting_on_nothing_is_an_error(stage):
    with pytest.raises(GraphError, match="no prims to act on: call it inside"):
        modify.attribute("size", 1.0)
    found = get.prims(path_pattern="nowhere")
    with pytest.raises(GraphError, match=r"no prims to act on: the item .* is empty"):
        modify.attribute("size", 1.0, input_prims=found)
    with found, pytest.raises(GraphError, match=r"no prims to act on: the item .* is empty"):
        modify.attribute("size", 1.0)


def test_an_unknown_event_is_named_with_its_near_miss(stage):
    randomize_sizes(stage, "randomize_lights")
    with pytest.warns(UsdsdgWarning, match="did you mean 'randomize_lights'"):
        utils.send_og_event("randomise_lights")


def test_nodes_of_items_stand_for_their_prims(stage):
    """Registered randomizers return `item.node`, and Replicator takes such nodes wherever it takes items."""
    box, ball, plane = create.cube(), create.sphere(position=(0, 0, 0)), create.plane(scale=4)
    assert create.group([box.node, ball.node]).prims == (*box.prims, *ball.prims)
    with trigger.on_frame():
        randomizer.scatter_2d(plane.node, no_coll_prims=[ball.node], check_for_collisions=True, input_prims=box.node)
    evaluate.graph().evaluate(preview=True)
    place = np.array(stage.GetPrimAtPath(box.prims[0]).GetAttribute("xformOp:translate").Get())
    # The unit cube on the plane of 4 units touches the unit ball at its center nowhere.
    assert np.abs(place).max() <= 2
    assert np.linalg.norm(np.maximum(np.abs(place) - 0.5, 0)) > 0.5
    modify.pose(position=(7, 8, 9), input_prims=[box.node])
    evaluate.graph().evaluate()
    camera = create.camera(position=(7, 8, 19), look_at=box.node)
    view = UsdGeom.Camera(stage.GetPrimAtPath(f"{camera.prims[0]}/Camera")).GetCamera(0).transform
    assert np.allclose(view.TransformDir((0, 0, -1)), (0, 0, -1), atol=1e-6)
