"""Commands of Kit that change composition, groups, relationships and several prims at once."""

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.compat.omni.kit.commands import execute
from usdsdg.compat.omni.usd import get_composed_payloads_from_prim, get_composed_references_from_prim
from usdsdg.errors import BadPrim
from usdsdg.session.timeline import get_timeline


def place(stage, path):
    return UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0).ExtractTranslation()


def moved_cube(stage, path, translation):
    UsdGeom.Cube.Define(stage, path).AddTranslateOp().Set(translation)
    return stage.GetPrimAtPath(path)


def test_instances_look_as_their_source(stage):
    UsdGeom.Xform.Define(stage, "/World/crate").AddTranslateOp().Set((1, 2, 3))
    moved_cube(stage, "/World/crate/box", (0, 0, 1))
    assert execute("CreateInstances", paths_from=["/World/crate", "/World/crate"])[1] == [
        "/World/crate_01",
        "/World/crate_02",
    ]
    made = stage.GetPrimAtPath("/World/crate_02")
    assert made.IsInstance()
    assert place(stage, "/World/crate_02/box") == Gf.Vec3d(1, 2, 4)


def test_references_and_payloads_are_removed_and_replaced(stage):
    sources = {}
    for name in ("Cube", "Sphere"):
        sources[name] = Usd.Stage.CreateInMemory()
        sources[name].SetDefaultPrim(sources[name].DefinePrim(f"/{name}", name))
    first, second = (Sdf.Reference(each.GetRootLayer().identifier) for each in sources.values())
    prim = stage.DefinePrim("/World/ref")
    prim.GetReferences().AddReference(first)
    execute("ReplaceReference", stage=stage, prim_path="/World/ref", old_reference=first, new_reference=second)
    assert prim.GetTypeName() == "Sphere"
    execute("RemoveReference", stage=stage, prim_path=prim.GetPath(), reference=second)
    assert prim.GetTypeName() == ""
    payload = Sdf.Payload(sources["Cube"].GetRootLayer().identifier)
    prim.GetPayloads().AddPayload(payload)
    assert prim.GetTypeName() == "Cube"
    execute("RemovePayload", stage=stage, prim_path="/World/ref", payload=payload)
    assert prim.GetTypeName() == ""


def test_references_are_listed_with_their_layers(stage):
    weaker = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.append(weaker.identifier)
    prim = stage.DefinePrim("/World/ref")
    first, second, third = (Sdf.Reference(f"/assets/SM_{name}.usd") for name in "abc")
    for layer, references in ((stage.GetRootLayer(), [first]), (weaker, [second, third, first])):
        spec = Sdf.CreatePrimInLayer(layer, prim.GetPath())
        spec.referenceList.prependedItems = references
    stage.GetPrimAtPath("/World/ref").GetReferences().RemoveReference(third)
    found = get_composed_references_from_prim(stage.GetPrimAtPath("/World/ref"), False)
    assert found == [(first, stage.GetRootLayer()), (second, weaker)]
    Sdf.CreatePrimInLayer(weaker, prim.GetPath()).payloadList.prependedItems = [Sdf.Payload("props\\mug.usd")]
    assert [payload.assetPath for payload, _ in get_composed_payloads_from_prim(prim)] == ["props/mug.usd"]


def test_prims_are_ungrouped_in_place(stage):
    UsdGeom.Xform.Define(stage, "/World/group").AddTranslateOp().Set((10, 0, 0))
    moved_cube(stage, "/World/group/a", (1, 0, 0))
    moved_cube(stage, "/World/a", (5, 0, 0))
    execute("UngroupPrims", prim_paths=["/World/group"])
    assert not stage.GetPrimAtPath("/World/group")
    assert (place(stage, "/World/a"), place(stage, "/World/a_01")) == (Gf.Vec3d(5, 0, 0), Gf.Vec3d(11, 0, 0))
    execute("UngroupPrims", prim_paths=["/World/a"])  # a shape, which groups nothing
    assert stage.GetPrimAtPath("/World/a")


def test_prims_take_part_or_not(stage):
    moved_cube(stage, "/World/a", (0, 0, 0))
    execute("ToggleActivePrims", prim_paths=["/World/a"], active=False)
    assert not stage.GetPrimAtPath("/World/a").IsActive()
    execute("ToggleActivePrims", prim_paths=["/World/a"], active=True)
    assert stage.GetPrimAtPath("/World/a").IsActive()
    with pytest.raises(BadPrim, match="/World/none is not on the stage"):
        execute("ToggleActivePrims", prim_paths=["/World/none"], active=True)


def test_attributes_and_targets_are_given_by_path(stage):
    cube = moved_cube(stage, "/World/a", (0, 0, 0))
    execute("CreateUsdAttributeOnPath", attr_path="/World/a.mine:x", attr_type=Sdf.ValueTypeNames.Int, attr_value=3)
    assert cube.GetAttribute("mine:x").Get() == 3
    relation = cube.CreateRelationship("mine:to")
    execute("AddRelationshipTarget", relationship=relation, target="/World")
    execute("AddRelationshipTarget", relationship=relation, target=Sdf.Path("/World/a"))
    execute("RemoveRelationshipTarget", relationship=relation, target="/World")
    assert relation.GetTargets() == [Sdf.Path("/World/a")]


def test_several_prims_are_placed_at_once(stage):
    paths = ["/World/a", "/World/b"]
    for path in paths:
        moved_cube(stage, path, (0, 0, 0))
    matrices = [Gf.Matrix4d().SetTranslate((x, 0, 0)) for x in (1, 2)]
    execute("TransformPrims", prims_to_transform=[(*each, Gf.Matrix4d(1)) for each in zip(paths, matrices)])
    assert [place(stage, path)[0] for path in paths] == [1, 2]
    poses = [(path, (0, 0, z), (0, 0, 90), (0, 1, 2), (2, 2, 2)) for path, z in zip(paths, (3, 4))]
    execute("TransformPrimsSRT", prims_to_transform=poses)
    for path, z in zip(paths, (3, 4)):
        matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(0)
        assert Gf.IsClose(matrix.Transform((1, 0, 0)), (0, 2, z), 1e-6)


def test_moves_tell_who_asks(stage):
    moved_cube(stage, "/World/a", (0, 0, 0))
    heard = []
    execute("MovePrims", paths_to_move={"/World/a": "/World/b"}, on_move_fn=lambda *paths: heard.append(paths))
    assert heard == [(Sdf.Path("/World/a"), Sdf.Path("/World/b"))]


def test_joints_are_made_where_prims_are(stage):
    first, second = moved_cube(stage, "/World/a", (0, 0, 0)), moved_cube(stage, "/World/b", (0, 0, 2))
    _, prim = execute("CreateJointCommand", stage=stage, joint_type="Fixed", from_prim=first, to_prim=second)
    joint = UsdPhysics.FixedJoint(prim)
    assert joint.GetBody0Rel().GetTargets() == [first.GetPath()]
    assert joint.GetLocalPos0Attr().Get() == Gf.Vec3f(0, 0, 2)
    _, prims = execute("CreateJoints", stage=stage, joint_type="Revolute", paths=["/World/a", "/World/b"])
    assert all(each.IsA(UsdPhysics.RevoluteJoint) for each in prims)


def test_a_texture_is_the_color_of_a_preview_surface(stage):
    path = execute("CreatePreviewSurfaceTextureMaterialPrim", mtl_path="/World/Looks/mat")[1]
    surface, _, _ = UsdShade.Material.Get(stage, path).ComputeSurfaceSource()
    source = surface.GetInput("diffuseColor").GetConnectedSources()[0][0].source.GetPrim()
    assert UsdShade.Shader(source).GetShaderId() == "UsdUVTexture"
    assert UsdShade.Shader(source).GetInput("st").HasConnectedSource()


def test_buttons_of_the_toolbar_play_the_timeline(stage):
    states = []
    for button in ("Play", "Pause", "Stop"):
        execute(f"Toolbar{button}ButtonClicked")
        states.append((get_timeline().is_playing(), get_timeline().is_stopped()))
    assert states == [(True, False), (False, False), (False, True)]
