"""What the arguments of `rep.create`'s shapes, lights, cameras, references and groups leave on the stage."""

from contextlib import nullcontext

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

import usdsdg as rep
from tests.stage.poses.euler import compose_euler
from usdsdg.errors import AssetNotFound, BadPrim, GraphError, Unsupported
from usdsdg.graph import evaluate
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.cameras.lens_attributes import LENS, OPTICS
from usdsdg.stage.semantics import labels as semantics

SHAPES = ["sphere", "torus", "disk", "plane", "cube", "cylinder", "cone"]
OF_USD = ["sphere", "plane", "cube", "cylinder", "cone"]


@pytest.fixture
def thing(tmp_path):
    """A USD file with a cube as its default prim."""
    made = Usd.Stage.CreateNew(str(tmp_path / "thing.usda"))
    made.SetDefaultPrim(made.DefinePrim("/Thing", "Cube"))
    made.Save()
    return str(tmp_path / "thing.usda")


def made_by(kind, thing, **arguments):
    return rep.create.from_usd(thing, **arguments) if kind == "from_usd" else getattr(rep.create, kind)(**arguments)


def matrix(stage, path):
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path)))


def labels(stage, item):
    return [semantics.get_labels(stage.GetPrimAtPath(path)) for path in item.prims]


# --- common arguments ---


@pytest.mark.parametrize("kind", [*SHAPES, "xform", "from_usd", "light", "camera"])
def test_poses_parents_names_and_counts(stage, thing, kind):
    parent = stage.GetPrimAtPath("/World")
    UsdGeom.Xformable(parent).AddTranslateOp().Set(Gf.Vec3d(0, 0, 7))
    # A camera has no scale.
    scale = {} if kind == "camera" else {"scale": (1, 2, 3)}
    item = made_by(kind, thing, position=(1, 2, 3), rotation=(10, 20, 30), name="it", parent=parent, count=2, **scale)
    suffix = "" if kind == "xform" else "_Xform"
    assert item.prims == (f"/World/it{suffix}", f"/World/it{suffix}_01")
    for path in item.prims:
        assert [child.GetName() for child in stage.GetPrimAtPath(path).GetChildren()] == ["it"] * (kind != "xform")
        expected = compose_euler((1, 2, 10), (10, 20, 30), scale.get("scale", (1, 1, 1)))
        np.testing.assert_allclose(matrix(stage, path), expected, atol=1e-6)
    assert made_by(kind, thing, count=0).prims == ()
    with pytest.raises(BadPrim, match=r"no prim /Wrld .*did you mean /World"):
        made_by(kind, thing, parent="/Wrld")


@pytest.mark.parametrize("kind", [*SHAPES, "xform", "from_usd", "light", "material_omnipbr"])
def test_many_are_what_as_many_calls_make(kind, thing):
    def content(make):
        stage = new_stage()
        stage.DefinePrim("/Replicator/it_Xform_02")  # taken, and so skipped
        made = make()
        return made, stage.GetRootLayer().ExportToString()

    named = {} if kind == "material_omnipbr" else {"name": "it"}
    at_once = content(lambda: made_by(kind, thing, count=4, **named).prims)
    one_by_one = content(lambda: tuple(path for _ in range(4) for path in made_by(kind, thing, **named).prims))
    assert at_once == one_by_one


@pytest.mark.parametrize("kind", [*SHAPES, "xform", "from_usd"])
def test_labels_and_look_at(stage, thing, kind):
    item = made_by(kind, thing, semantics=[[("class", "a")], {"class": ["b", "c"]}], count=2, look_at=(0, 0, -9))
    assert labels(stage, item) == [{"class": ["a"]}, {"class": ["b", "c"]}]
    np.testing.assert_allclose(-matrix(stage, item.prims[0])[2, :3], (0, 0, -1), atol=1e-6)
    turned = made_by(kind, thing, look_at=(9, 0, 0), look_at_up_axis=(0, 1, 0))
    np.testing.assert_allclose(matrix(stage, turned.prims[0])[1:3, :3], [(0, 1, 0), (-1, 0, 0)], atol=1e-6)


@pytest.mark.parametrize("kind", [*SHAPES, "xform"])
def test_visibility(stage, kind):
    def shown(item):
        return [UsdGeom.Imageable(stage.GetPrimAtPath(path)).ComputeVisibility() for path in item.prims]

    assert shown(getattr(rep.create, kind)()) == ["inherited"]
    assert shown(getattr(rep.create, kind)(visible=False)) == ["invisible"]
    assert shown(getattr(rep.create, kind)(visible=[False, True], count=2)) == ["invisible", "inherited"]


@pytest.mark.parametrize("kind", SHAPES)
def test_distributions_as_arguments_are_sampled_when_the_trigger_fires(stage, kind):
    draw = rep.distribution
    with rep.trigger.on_custom_event("go"):
        item = getattr(rep.create, kind)(
            position=draw.uniform((1, 1, 1), (2, 2, 2)), scale=draw.uniform(2, 3), visible=draw.sequence([False, True]),
            count=2,
        )  # fmt: skip
    np.testing.assert_array_equal(matrix(stage, item.prims[0]), np.eye(4))
    for shown in ("invisible", "invisible"), ("inherited", "inherited"):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        for path, each in zip(item.prims, shown):
            found = matrix(stage, path)
            assert ((found[3, :3] >= 1) & (found[3, :3] < 2)).all()
            assert 2 <= found[0, 0] == found[1, 1] == found[2, 2] < 3
            assert UsdGeom.Imageable(stage.GetPrimAtPath(path)).ComputeVisibility() == each


def test_a_random_up_axis_applies_to_a_constant_look_at_target(stage):
    up = rep.distribution.choice([(0, 1, 0)])
    item = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0), look_at_up_axis=up)
    evaluate.graph().evaluate()
    np.testing.assert_allclose(matrix(stage, f"{item.prims[0]}/Camera")[1, :3], (0, 1, 0), atol=1e-6)


def view_of(stage, path):
    """Origin and view direction of a prim, of a camera those of its child."""
    child = stage.GetPrimAtPath(f"{path}/Camera")
    prim = child if child else stage.GetPrimAtPath(path)
    placed = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    return np.array(placed.ExtractTranslation()), np.array(placed.TransformDir(Gf.Vec3d(0, 0, -1)))


def looks_at(stage, path, target):
    eye, view = view_of(stage, path)
    wanted = np.array(target) - eye
    np.testing.assert_allclose(view, wanted / np.linalg.norm(wanted), atol=1e-6)


@pytest.mark.parametrize("target", ["point", "item", "node", "path"])
@pytest.mark.parametrize("kind", ["camera", "light", "cube", "xform"])
@pytest.mark.parametrize("triggered", [True, False])
def test_what_is_placed_at_random_looks_at_its_target_from_there(stage, kind, target, triggered):
    # The target lies at the origin, where new prims are before they are placed.
    ball = rep.create.sphere()
    look_at = {"point": (0, 0, 0), "item": ball, "node": ball.node, "path": ball.prims[0]}[target]
    places = rep.distribution.uniform((100, 100, 500), (200, 200, 600))
    with rep.trigger.on_custom_event("go") if triggered else nullcontext():
        item = getattr(rep.create, kind)(position=places, look_at=look_at, count=2)
    seen = []
    for _ in range(3 if triggered else 1):
        if triggered:
            rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        for path in item.prims:
            looks_at(stage, path, (0, 0, 0))
            seen.append(tuple(view_of(stage, path)[0]))
    assert len(set(seen)) == len(seen)


def test_new_cameras_follow_the_item_that_they_look_at(stage):
    moved = rep.create.sphere(position=rep.distribution.uniform((5, -9, 0), (6, 9, 0)))
    early, still = rep.create.camera(look_at=moved), rep.create.camera(look_at=(1, 0, 0))
    with rep.trigger.on_custom_event("go"):
        with moved:
            rep.modify.pose(position=rep.distribution.uniform((-6, -9, 0), (-5, 9, 0)))
        late, both = rep.create.camera(look_at=moved), rep.create.camera(look_at=[moved, rep.create.cube()])
    evaluate.graph().evaluate()
    first, _ = view_of(stage, moved.prims[0])
    looks_at(stage, early.prims[0], first)
    for _ in range(2):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        place, _ = view_of(stage, moved.prims[0])
        looks_at(stage, late.prims[0], place)
        looks_at(stage, both.prims[0], place / 2)
        looks_at(stage, early.prims[0], first)
        looks_at(stage, still.prims[0], (1, 0, 0))


def test_a_target_changes_nothing_of_what_is_drawn_for_positions(stage):
    places = []
    for target, up in (None, None), ((0, 0, 0), None), ((0, 0, 0), (1, 0, 0)):
        stage = new_stage()
        position = rep.distribution.uniform((1, 1, 1), (2, 2, 2))
        item = rep.create.camera(position=position, look_at=target, look_at_up_axis=up)
        evaluate.graph().evaluate()
        places.append(view_of(stage, item.prims[0])[0].tolist())
    assert places == [places[0]] * 3


# --- shapes ---


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize(("up", "unit"), [("Z", 1.0), ("Y", 0.01)])
def test_meshes_are_a_meter_across_and_aligned_with_the_up_axis(stage, kind, up, unit):
    rep.settings.set_stage_up_axis(up)
    rep.settings.set_stage_meters_per_unit(unit)
    child = stage.GetPrimAtPath(f"{getattr(rep.create, kind)().prims[0]}/{kind.capitalize()}")
    assert child.IsA(UsdGeom.Mesh)
    size = np.ptp(np.array(UsdGeom.Mesh(child).GetPointsAttr().Get()), axis=0)
    height, width = {"plane": 0, "disk": 0, "torus": 0.5}.get(kind, 1), 1.5 if kind == "torus" else 1
    expected = (width, width, height) if up == "Z" else (width, height, width)
    np.testing.assert_allclose(size * unit, expected, atol=1e-3)


@pytest.mark.parametrize("kind", OF_USD)
def test_shapes_of_usd_have_its_sizes(stage, kind):
    child = stage.GetPrimAtPath(f"{getattr(rep.create, kind)(as_mesh=False).prims[0]}/{kind.capitalize()}")
    plain = stage.DefinePrim("/plain", kind.capitalize())
    assert child.GetTypeName() == kind.capitalize()
    for name in ("size", "radius", "height", "width", "length"):
        assert child.GetAttribute(name).Get() == plain.GetAttribute(name).Get()


@pytest.mark.parametrize("kind", ["torus", "disk"])
def test_usd_has_no_such_shape(stage, kind):
    with pytest.raises(Unsupported, match=kind):
        getattr(rep.create, kind)(as_mesh=False)


@pytest.mark.parametrize("kind", ["sphere", "torus", "cube", "cylinder", "cone"])
def test_a_pivot_is_what_is_placed(stage, kind):
    item = getattr(rep.create, kind)(position=(1, 2, 3), pivot=(1, 0, 0), scale=2)
    half = 0.75 if kind == "torus" else 0.5
    np.testing.assert_allclose(np.array([half, 0, 0, 1]) @ matrix(stage, item.prims[0]), (1, 2, 3, 1), atol=1e-3)


# --- lights ---


@pytest.mark.parametrize("kind", ["Cylinder", "Disk", "Distant", "Dome", "Rect", "Sphere"])
def test_the_arguments_of_a_light_reach_its_attributes(stage, kind):
    item = rep.create.light(
        light_type=kind.upper(), color=(1, 0.5, 0), intensity=7, exposure=2, temperature=3000, count=2
    )
    assert len(item.prims) == 2
    for path in item.prims:
        light = UsdLux.LightAPI(stage.GetPrimAtPath(f"{path}/{kind}Light"))
        assert light.GetPrim().GetTypeName() == f"{kind}Light"
        assert light.GetColorAttr().Get() == (1, 0.5, 0)
        read = (light.GetIntensityAttr(), light.GetExposureAttr(), light.GetColorTemperatureAttr())
        assert [attribute.Get() for attribute in read] == [7, 2, 3000]
        assert light.GetEnableColorTemperatureAttr().Get() is True


def test_the_defaults_of_a_light(stage):
    light = UsdLux.LightAPI(stage.GetPrimAtPath(f"{rep.create.light().prims[0]}/DistantLight"))
    read = (light.GetIntensityAttr(), light.GetExposureAttr(), light.GetColorTemperatureAttr(), light.GetColorAttr())
    assert [attribute.Get() for attribute in read] == [1000, 0, 6500, (1, 1, 1)]
    cold = rep.create.light(temperature=None)
    enabled = UsdLux.LightAPI(stage.GetPrimAtPath(f"{cold.prims[0]}/DistantLight")).GetEnableColorTemperatureAttr()
    assert enabled.Get() is False


def test_light_textures_must_be_existing_files(stage, tmp_path):
    (tmp_path / "night.hdr").write_bytes(b"")
    for kind in ("dome", "rect"):
        item = rep.create.light(light_type=kind, texture=str(tmp_path / "night.hdr"))
        light = stage.GetPrimAtPath(f"{item.prims[0]}/{kind.capitalize()}Light")
        assert light.GetAttribute("inputs:texture:file").Get().path == str(tmp_path / "night.hdr")
    with pytest.raises(AssetNotFound, match=r"did you mean night\.hdr"):
        rep.create.light(light_type="dome", texture=str(tmp_path / "nigth.hdr"))
    with pytest.raises(GraphError, match="a sphere light has no texture; give it to a dome or rect light"):
        rep.create.light(light_type="sphere", texture=str(tmp_path / "night.hdr"))


# --- cameras ---

NUMBERS = OPTICS | LENS


@pytest.mark.parametrize("argument", NUMBERS)
def test_each_number_of_a_lens_reaches_its_attribute(stage, argument):
    item = rep.create.camera(projection_type="fisheye_polynomial", count=2, **{argument: [0.25, 0.75]})
    found = [stage.GetPrimAtPath(f"{path}/Camera").GetAttribute(NUMBERS[argument]).Get() for path in item.prims]
    assert found == [0.25, 0.75]


def test_numbers_of_a_lens_can_be_drawn(stage):
    with rep.trigger.on_custom_event("go"):
        item = rep.create.camera(focal_length=rep.distribution.sequence([20, 30, 40], stride=2), count=2)
    seen = []
    for _ in range(2):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        seen += [stage.GetPrimAtPath(f"{path}/Camera").GetAttribute("focalLength").Get() for path in item.prims]
    assert seen == [20, 30, 40, 20]


def test_ranges_and_partners_of_cameras(stage):
    item = rep.create.camera(clipping_range=(0.5, 60), cross_camera_reference_name=["right", "left"], count=2)
    for path, partner in zip(item.prims, ("right", "left")):
        camera = stage.GetPrimAtPath(f"{path}/Camera")
        assert camera.GetAttribute("clippingRange").Get() == (0.5, 60)
        assert camera.GetAttribute("crossCameraReferenceName").Get() == partner
    plain = stage.GetPrimAtPath(f"{rep.create.camera().prims[0]}/Camera")
    assert plain.GetAttribute("clippingRange").Get() == (1, 1000000)
    assert not plain.HasAttribute("crossCameraReferenceName")
    pair = rep.create.stereo_camera(0.1, cross_camera_reference_name="other", fisheye_max_fov=90, clipping_range=(1, 2))
    for child in (each.GetChildren()[0] for each in stage.GetPrimAtPath(pair.prims[0]).GetChildren()):
        assert child.GetAttribute("crossCameraReferenceName").Get() == "other"
        assert child.GetAttribute("clippingRange").Get() == (1, 2)


# --- references, groups, materials ---


def test_references_show_their_file(stage, thing):
    item = rep.create.from_usd(thing, count=2)
    assert item.prims == ("/Replicator/Ref_Xform", "/Replicator/Ref_Xform_01")
    assert [stage.GetPrimAtPath(f"{path}/Ref").GetTypeName() for path in item.prims] == ["Cube", "Cube"]
    with pytest.raises(AssetNotFound, match=r"did you mean thing\.usda"):
        rep.create.from_usd(thing.replace("thing", "thign"))


def test_a_group_keeps_its_order_and_labels_its_members(stage):
    one, two = rep.create.cube(count=2), rep.create.sphere()
    group = rep.create.group([two, "/World", one.prims[1]], semantics=[("class", "x")], name="things")
    assert group.prims == (two.prims[0], "/World", one.prims[1])
    assert labels(stage, group) == [{"class": ["x"]}] * 3
    assert labels(stage, one)[0] == {}
    assert group.node.name == "things"
    with pytest.raises(ValueError, match=r"no prim /Replicator/Sphere_Xfrm .*did you mean /Replicator/Sphere_Xform"):
        rep.create.group(["/World", "/Replicator/Sphere_Xfrm"])
    with pytest.raises(ValueError, match="expected an item, prim, path or a list of these, got int: 5"):
        rep.create.group(5)


@pytest.mark.parametrize("kind", SHAPES)
def test_a_material_is_bound_to_a_shape(stage, kind):
    red = rep.create.material_omnipbr(diffuse=(1, 0, 0))
    item = getattr(rep.create, kind)(material=red, count=2)
    assert len(item.prims) == 2
    for path in item.prims:
        child = stage.GetPrimAtPath(f"{path}/{kind.capitalize()}")
        assert str(UsdShade.MaterialBindingAPI(child).ComputeBoundMaterial()[0].GetPath()) == red.prims[0]
