"""Randomizers and modifiers of PointInstancers that a script or a file has put on the stage: each instance counts."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.graph import evaluate
from usdsdg.scatter.collisions import collide
from usdsdg.scatter.solid import Solids
from usdsdg.stage.geometry.triangles import triangles_below

uniform = rep.distribution.uniform


def instancer(stage, count=6, path="/World/Rocks"):
    """A PointInstancer of cubes and spheres with a single position, as files have that leave the others to a script."""
    made = UsdGeom.PointInstancer.Define(stage, path)
    kinds = [stage.DefinePrim(f"{path}/cube", "Cube"), stage.DefinePrim(f"{path}/ball", "Sphere")]
    UsdGeom.Cube(kinds[0]).CreateSizeAttr(0.4)
    UsdGeom.Sphere(kinds[1]).CreateRadiusAttr(0.2)
    for kind in kinds:
        rep.functional.modify.semantics(kind, {"class": kind.GetName()})
    made.CreatePrototypesRel().SetTargets([kind.GetPath() for kind in kinds])
    made.CreateProtoIndicesAttr([index % 2 for index in range(count)])
    made.CreatePositionsAttr([(0, 0, 0)])
    return made.GetPrim()


def run():
    evaluate.graph().evaluate()


def values(prim, name):
    return np.array(prim.GetAttribute(name).Get(), float)


def has_no_ops(prim):
    return not UsdGeom.Xformable(prim).GetOrderedXformOps()


@pytest.mark.parametrize("of", ["group", "prim_at_path", "prims", "input_prims"])
def test_each_instance_is_scattered_in_the_world_and_the_instancer_stays(stage, of):
    rocks = instancer(stage, 40)
    UsdGeom.Xformable(rocks.GetParent()).AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
    block = rep.create.cube(position=(3, 4, 5), scale=2)
    items = {
        "group": lambda: rep.create.group([str(rocks.GetPath())]),
        "prim_at_path": lambda: rep.get.prim_at_path(str(rocks.GetPath())),
        "prims": lambda: rep.get.prims(prim_types=["PointInstancer"]),
        "input_prims": lambda: [str(rocks.GetPath())],
    }
    rep.randomizer.scatter_3d(block, input_prims=items[of]())
    run()
    positions = values(rocks, "positions")
    assert positions.shape == (40, 3)
    assert len(np.unique(positions, axis=0)) == 40
    assert (np.abs(positions - np.array((-97, 4, 5))) <= 1 + 1e-4).all()
    assert has_no_ops(rocks)


def test_instances_are_scattered_among_prims_without_collisions_also_where_some_are_not_drawn(stage):
    rocks, floor = instancer(stage, 25), rep.create.plane(scale=5)
    rocks.GetAttribute("invisibleIds").Set([0, 7])
    cones = rep.create.cone(count=4, scale=0.5)
    with rep.create.group([str(rocks.GetPath()), cones]):
        rep.randomizer.scatter_2d(floor, offset=0.3, check_for_collisions=True)
    run()
    assert values(rocks, "positions").shape == (25, 3)
    prims = [rocks, *(stage.GetPrimAtPath(path) for path in cones.prims)]
    placed = triangles_below(prims)
    # Two instances are not drawn, and have no triangles.
    assert len(placed) == 23 + 4
    assert placed[0].path.endswith("[1]")
    origins = [each.to_world[3, :3] for each in placed]
    bodies = [Solids().around(origin, [each]) for origin, each in zip(origins, placed)]
    assert not any(collide(bodies[i], bodies[j], origins[j] - origins[i]) for i in range(27) for j in range(i + 1, 27))


def test_each_instance_gets_its_own_rotation_within_the_bounds(stage):
    rocks = instancer(stage, 30)
    rep.randomizer.rotation(min_angle=(0, 0, 10), max_angle=(0.01, 0.01, 60), input_prims=[str(rocks.GetPath())])
    run()
    turns = [Gf.Rotation(Gf.Quatd(quat)) for quat in rocks.GetAttribute("orientations").Get()]
    angles = [turn.GetAngle() * np.sign(turn.GetAxis()[2]) for turn in turns]
    # Orientations have half precision.
    assert len(angles) == 30
    assert min(angles) > 9.9
    assert max(angles) < 60.1
    assert np.ptp(angles) > 25
    assert has_no_ops(rocks)


def test_poses_are_those_of_instances_also_of_a_group_with_prims(stage):
    rocks, cone = instancer(stage, 4), rep.create.cone()
    five = [(float(index), 0.0, 1.0) for index in range(5)]
    with rep.create.group([str(rocks.GetPath()), cone]):
        rep.modify.pose(position=five, rotation=(0, 0, 90), scale=uniform(0.5, 1))
        rep.modify.pose(position_y=[7, 8])
    run()
    np.testing.assert_allclose(values(rocks, "positions"), [(x, 7, 1) for x in range(4)])
    assert tuple(stage.GetPrimAtPath(cone.prims[0]).GetAttribute("xformOp:translate").Get()) == (4, 8, 1)
    for quat in rocks.GetAttribute("orientations").Get():
        assert (quat.GetReal(), quat.GetImaginary()[2]) == pytest.approx((np.sqrt(0.5), np.sqrt(0.5)), abs=1e-3)
    scales = values(rocks, "scales")
    assert scales.shape == (4, 3)
    assert len(np.unique(scales)) == 4
    assert ((scales >= 0.5) & (scales < 1)).all()


def test_a_single_angle_keeps_the_others(stage):
    rocks = instancer(stage, 3)
    with rep.get.prim_at_path(str(rocks.GetPath())):
        rep.modify.pose(rotation=(10, 20, 30))
        rep.modify.pose(rotation_z=50)
    run()
    turn = Gf.Rotation((1, 0, 0), 10) * Gf.Rotation((0, 1, 0), 20) * Gf.Rotation((0, 0, 1), 50)
    quats = rocks.GetAttribute("orientations").Get()
    assert len(quats) == 3
    for quat in quats:
        between = Gf.Rotation(Gf.Quatd(quat)) * turn.GetInverse()
        assert min(between.GetAngle(), 360 - between.GetAngle()) < 0.2


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("positions", (0, 0, 0), (1, 2, 3)),
        ("velocities", (0, 0, 0), (1, 2, 3)),
        ("angularVelocities", (-9, 0, 0), (9, 0, 0)),
        ("scales", (1, 1, 1), (2, 2, 2)),
        ("orientations", (0.1, 0, 0, 0.1), (1, 0, 0, 1)),
    ],
)
def test_attributes_of_instances_have_one_value_for_each(stage, name, low, high):
    rocks = instancer(stage, 8)
    rep.modify.attribute(name, uniform(low, high), input_prims=[str(rocks.GetPath())])
    run()
    if name == "orientations":
        quats = rocks.GetAttribute(name).Get()
        assert len({quat.GetReal() for quat in quats}) > 5
        assert all(quat.GetLength() == pytest.approx(1, abs=2e-3) for quat in quats)
        assert all(quat.GetImaginary()[0] == 0 < quat.GetImaginary()[2] for quat in quats)
        return
    found = values(rocks, name)
    assert found.shape == (8, 3)
    assert len(np.unique(found, axis=0)) == 8
    assert ((found >= low) & (found <= high)).all()


def test_ops_are_those_of_instances_and_what_only_prototypes_have_is_theirs(stage):
    rocks = instancer(stage, 3)
    with rep.create.group([str(rocks.GetPath())]):
        rep.modify.attribute("xformOp:translate", [(1, 0, 0), (2, 0, 0), (3, 0, 0)])
        rep.modify.attribute("xformOp:rotateXYZ", (0, 0, 180))
        rep.modify.attribute("size", 0.75)
        rep.modify.attribute("visibility", "invisible")
    with pytest.raises(GraphError, match="/World/Rocks/ball has no attribute 'size'"):
        run()
    assert has_no_ops(rocks)
    np.testing.assert_allclose(values(rocks, "positions"), [(1, 0, 0), (2, 0, 0), (3, 0, 0)])
    assert rocks.GetAttribute("orientations").Get()[2].GetImaginary()[2] == pytest.approx(1, abs=1e-3)
    assert rocks.GetChild("cube").GetAttribute("size").Get() == 0.75


def test_an_array_can_come_before_the_instances(stage):
    rocks = instancer(stage, 0)
    rep.modify.attribute("positions", [(1, 0, 0), (2, 0, 0)], input_prims=[str(rocks.GetPath())])
    run()
    assert values(rocks, "positions").tolist() == [[1, 0, 0], [2, 0, 0]]


def test_materials_are_drawn_for_each_prototype_wherever_it_is(stage):
    rocks, cone = instancer(stage, 5), rep.create.cone()
    far = stage.DefinePrim("/Elsewhere/mesh", "Cube")
    rocks.GetRelationship("prototypes").AddTarget(far.GetPath())
    paints = rep.create.material_omnipbr(count=5)
    with rep.trigger.on_custom_event("go"), rep.create.group([str(rocks.GetPath()), cone]):
        rep.randomizer.materials(paints)
    prims = [rocks.GetChild("cube"), rocks.GetChild("ball"), far, stage.GetPrimAtPath(cone.prims[0])]
    drawn = set()
    for _ in range(8):
        rep.utils.send_og_event("go")
        run()
        bound = [UsdShade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterialPath() for prim in prims]
        assert {str(path) for path in bound} <= set(paints.prims)
        drawn.add(tuple(bound))
    assert len(drawn) > 4
    assert any(len(set(each)) > 1 for each in drawn)
    assert not UsdShade.MaterialBindingAPI(rocks).GetDirectBinding().GetMaterialPath()


def test_colors_of_each_mesh_are_those_of_the_prototypes(stage):
    rocks = instancer(stage, 3)
    rep.randomizer.color([(1, 0, 0)], per_sub_mesh=True, input_prims=[str(rocks.GetPath())])
    run()
    assert len(rocks.GetChildren()) > 1
    for kind in rocks.GetChildren():
        assert UsdShade.MaterialBindingAPI(kind).GetDirectBinding().GetMaterialPath(), kind


def test_draws_of_an_instance_do_not_depend_on_other_targets(stage):
    rocks, others = instancer(stage, 3), instancer(stage, 2, "/World/Others")
    rep.modify.pose(position=uniform((0, 0, 0), (1, 1, 1)), input_prims=[str(rocks.GetPath())], name="poses")
    run()
    alone = values(rocks, "positions")
    both = [str(others.GetPath()), str(rocks.GetPath())]
    rep.modify.pose(position=uniform((0, 0, 0), (1, 1, 1)), input_prims=both, name="poses")
    evaluate.graph().impulses[0].key = evaluate.graph().impulses[0].key.replace("#1", "#0")
    run()
    np.testing.assert_array_equal(values(rocks, "positions"), alone)
    assert len(values(others, "positions")) == 2


def test_every_frame_shows_the_instances_where_they_have_been_scattered(stage):
    rocks = instancer(stage, 5)
    camera = rep.create.camera(position=(20, 0, 0), look_at=(0, 0, 0), focal_length=24, horizontal_aperture=24)
    with rep.trigger.on_frame(), rep.get.prim_at_path(str(rocks.GetPath())):
        rep.randomizer.rotation(min_angle=(0, 0, 0), max_angle=(0.01, 0.01, 90))
        rep.randomizer.scatter_3d(min_samp=(-0.01, -8, -8), max_samp=(0.01, 8, 8), check_for_collisions=True)
    boxes = rep.annotators.get("bounding_box_2d_tight", init_params={"semanticTypes": ["class"]})
    boxes.attach(rep.create.render_product(camera, (400, 400)))
    frames = []
    for _ in range(2):
        rep.orchestrator.step()
        found = boxes.get_data()
        labels = {int(key): value["class"] for key, value in found["info"]["idToLabels"].items()}
        assert sorted(labels[int(row["semanticId"])] for row in found["data"]) == ["ball"] * 2 + ["cube"] * 3
        centers = [((row["x_min"] + row["x_max"]) / 2, (row["y_min"] + row["y_max"]) / 2) for row in found["data"]]
        # A pinhole of 45 degrees to the side, 20 in front of the plane in which the instances are: 20 pixels per unit.
        seen = values(rocks, "positions")[:, 1:] * (20, -20) + 200
        frames.append(seen)
        near = np.linalg.norm(np.array(centers)[:, None] - seen[None], axis=-1).min(1)
        # Boxes end at whole pixels, and the fronts of the rocks are 0.2 nearer than their middles.
        assert near.max() < 3
    assert np.abs(frames[0] - frames[1]).max() > 10
