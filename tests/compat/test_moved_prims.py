"""Prims that scripts move or rename: items, nodes of the graph and open blocks follow them."""

import pytest
from pxr import UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.compat.isaacsim.core.experimental.utils import stage as experimental
from usdsdg.compat.isaacsim.core.utils import prims
from usdsdg.compat.omni.kit.commands import execute
from usdsdg.errors import Unsupported
from usdsdg.graph import evaluate

MOVES = {
    "MovePrim": lambda here, there: execute("MovePrim", path_from=here, path_to=there),
    "MovePrims": lambda here, there: execute("MovePrims", paths_to_move={here: there}),
    "isaacsim.core.utils": prims.move_prim,
    "isaacsim.core.experimental.utils": experimental.move_prim,
}


def fire():
    evaluate.graph().evaluate(preview=True)


def place(stage, path):
    return tuple(UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0).ExtractTranslation())


@pytest.mark.parametrize("how", MOVES)
def test_items_and_their_nodes_follow(stage, how):
    cube = rep.create.cube(name="box")
    with rep.trigger.on_frame(), cube:
        pose = rep.modify.pose(position=rep.distribution.sequence([(1, 0, 0), (2, 0, 0), (3, 0, 0)]))
    fire()
    MOVES[how](cube.prims[0], "/World/moved")
    assert cube.prims == pose.prims == ("/World/moved",)
    assert cube.get_output_prims()["prims"] == [stage.GetPrimAtPath("/World/moved")]
    fire()
    assert place(stage, "/World/moved") == (2, 0, 0)
    node = stage.GetPrimAtPath(pose.node.get_prim_path())
    assert [str(path) for path in node.GetRelationship("inputs:prims").GetTargets()] == ["/World/moved"]


def test_prims_below_one_that_is_moved_are_followed_and_others_with_such_a_name_are_not(stage):
    for path in ("/World/shelf", "/World/shelf_2"):
        UsdGeom.Xform.Define(stage, path)
    below, beside = rep.create.cube(name="a", parent="/World/shelf"), rep.create.cube(name="a", parent="/World/shelf_2")
    group = rep.create.group([below, beside])
    execute("MovePrim", path_from="/World/shelf", path_to="/World/rack")
    assert group.prims == ("/World/rack/a_Xform", "/World/shelf_2/a_Xform")
    with rep.trigger.on_frame(), group:
        rep.modify.pose(position=(0, 0, 5))
    fire()
    assert [place(stage, path) for path in group.prims] == [(0, 0, 5)] * 2


def test_targets_surfaces_and_choices_follow(stage):
    target, surface = rep.create.sphere(name="target", position=(0, 0, 9)), rep.create.plane(name="table", scale=0.01)
    camera, cube = rep.create.camera(position=(0, 0, 3)), rep.create.cube(scale=0.001)
    with rep.trigger.on_frame():
        with camera:
            rep.modify.pose(look_at=target)
        with cube:
            rep.randomizer.scatter_2d(surface)
        with rep.create.cone() as cone:
            rep.modify.pose(look_at=rep.distribution.choice(target.prims))
    fire()
    execute("MovePrim", path_from=target.prims[0], path_to="/World/ball")
    execute("MovePrim", path_from=surface.prims[0], path_to="/World/desk")
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/desk")).SetTranslate((50, 0, 0))
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World/ball")).SetTranslate((0, 0, -9))
    fire()
    assert place(stage, cube.prims[0])[0] == pytest.approx(50, abs=1)
    for path in (stage.GetPrimAtPath(camera.prims[0]).GetChildren()[0].GetPath(), cone.prims[0]):
        matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0)
        assert matrix.TransformDir((0, 0, -1))[2] == pytest.approx(-1)


def test_materials_of_randomizers_follow_prims_and_are_followed(stage):
    cube = rep.create.cube()
    with rep.trigger.on_frame(), cube:
        rep.randomizer.color(rep.distribution.sequence([(1, 0, 0), (0, 1, 0), (0, 0, 1)]))
    fire()
    execute("MovePrim", path_from=cube.prims[0], path_to="/World/moved")
    execute("MovePrim", path_from="/Replicator/Looks", path_to="/World/Looks")
    fire()
    material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/World/moved/Cube")).ComputeBoundMaterial()
    color = material.GetPrim().GetChild("Shader").GetAttribute("inputs:diffuse_color_constant").Get()
    assert tuple(color) == (0, 1, 0)


def test_a_block_that_is_open_follows(stage):
    cube = rep.create.cube(name="box")
    with cube:
        execute("MovePrim", path_from=cube.prims[0], path_to="/World/moved")
        rep.modify.pose(position=(4, 0, 0))
    evaluate.graph().evaluate()
    assert place(stage, "/World/moved") == (4, 0, 0)


def test_texts_that_name_no_prim_stay(stage):
    UsdGeom.Xform.Define(stage, "/data")
    cube = rep.create.cube()
    labeled = rep.modify.semantics([("class", "/data/mug")], input_prims=cube)
    execute("MovePrim", path_from="/data", path_to="/other")
    assert "/data/mug" in str(labeled.node.inputs)


def test_items_of_an_earlier_stage_stay_as_they_are(stage):
    cube = rep.create.cube(name="box")
    path = cube.prims[0]
    rep.new_stage()
    rep.create.cube(name="box")
    execute("MovePrim", path_from=path, path_to="/World/moved")
    assert cube.prims == (path,)


def test_a_move_that_fails_changes_nothing(stage):
    UsdGeom.Cube.Define(stage, "/World/taken")
    cube = rep.create.cube(name="box")
    with pytest.raises(Unsupported, match="that path is taken"):
        execute("MovePrim", path_from=cube.prims[0], path_to="/World/taken")
    assert cube.prims == ("/Replicator/box_Xform",)


def test_prims_are_moved_to_the_top(stage):
    UsdGeom.Xform.Define(stage, "/World/a").AddTranslateOp().Set((1, 2, 3))
    inner = rep.create.cube(name="inner", parent="/World/a")
    execute("UnparentPrims", paths=[inner.prims[0], "/World"])
    assert inner.prims == ("/inner_Xform",)
    assert place(stage, "/inner_Xform") == (1, 2, 3)
    assert stage.GetPrimAtPath("/World/a")
