"""Prims that functional.create and create_batch author."""

import ast
import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from tests.functional.poses import local, ops, value, world
from tests.stage.poses.euler import compose_euler
from usdsdg.errors import AssetError, AssetNotFound, BadPrim, GraphError, Unsupported, UsdsdgWarning
from usdsdg.functional import create, create_batch
from usdsdg.stage.cameras.lens_attributes import LENS, OPTICS
from usdsdg.stage.semantics.labels import get_labels

SHAPES = ["plane", "sphere", "torus", "disk", "cube", "cylinder", "cone", "capsule"]
LIGHTS = {
    "sphere_light": UsdLux.SphereLight,
    "disk_light": UsdLux.DiskLight,
    "rect_light": UsdLux.RectLight,
    "cylinder_light": UsdLux.CylinderLight,
    "distant_light": UsdLux.DistantLight,
    "dome_light": UsdLux.DomeLight,
}
OTHERS = ["scope", "xform", "camera"]
STANDARD_OPS = ["xformOp:translate", "xformOp:orient", "xformOp:scale"]


def extent(prim):
    """Return the lower and upper bound (2, 3) of a shape's points."""
    return np.array(prim.GetAttribute("extent").Get())


# --- names, parents, transforms ---


@pytest.mark.parametrize("kind", [*SHAPES, *LIGHTS, *OTHERS])
def test_default_names_are_those_of_types_with_a_number_if_taken(stage, kind):
    name = "".join(part.capitalize() for part in kind.split("_"))
    assert str(getattr(create, kind)().GetPath()) == f"/{name}"
    assert str(getattr(create, kind)(parent="/World").GetPath()) == f"/World/{name}"
    batch = getattr(create_batch, kind)(count=2, parent="/World")
    assert [str(prim.GetPath()) for prim in batch] == [f"/World/{name}_01", f"/World/{name}_02"]
    named = getattr(create, kind)(name="it", parent=stage.GetPrimAtPath("/World"))
    assert str(named.GetPath()) == "/World/it"
    assert ops(named) == ([] if kind == "scope" else STANDARD_OPS)


def test_a_number_in_a_given_name_is_kept(stage):
    assert [str(create.xform(name="cam_0").GetPath()) for _ in range(2)] == ["/cam_0", "/cam_0_01"]


def test_each_prim_may_have_its_own_parent(stage):
    rooms = create_batch.xform(count=2, name="room")
    cubes = create_batch.cube(count=2, parent=rooms)
    assert [str(cube.GetPath()) for cube in cubes] == ["/room/Cube", "/room_01/Cube"]
    twins = create_batch.cube(count=2, parent=["/room", "/room"])
    assert [str(cube.GetPath()) for cube in twins] == ["/room/Cube_01", "/room/Cube_02"]


def test_names_that_usd_does_not_allow_are_changed_with_a_warning(stage):
    with pytest.warns(UsdsdgWarning, match="'my cube' cannot be the name"):
        assert create.cube(name="my cube").GetName() == "my_cube"


def test_invalid_parents_and_counts_raise_errors(stage):
    with pytest.raises(BadPrim, match="no prim /Nowhere"):
        create.cube(parent="/Nowhere")
    with pytest.raises(BadPrim, match="/Cube is a Mesh"):
        create.sphere(parent=create.cube())
    with pytest.raises(GraphError, match="parent has 1 prim for count 2"):
        create_batch.cube(count=2, parent=["/World"])
    with pytest.raises(GraphError, match="count is -1"):
        create_batch.cube(count=-1)
    assert create_batch.cube(count=0) == []


def test_prims_are_authored_in_the_edit_target(stage):
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        create.cube(position=(1, 2, 3))
    assert not stage.GetRootLayer().GetPrimAtPath("/Cube")
    assert stage.GetSessionLayer().GetAttributeAtPath("/Cube.xformOp:translate").default == Gf.Vec3d(1, 2, 3)


# --- common arguments ---


@pytest.mark.parametrize("kind", [*SHAPES, *LIGHTS, "xform", "camera"])
def test_poses(stage, kind):
    prim = getattr(create, kind)(position=(1, 2, 3), rotation=(10, 20, 30), scale=(2, 3, 4))
    np.testing.assert_allclose(local(prim), compose_euler((1, 2, 3), (10, 20, 30), (2, 3, 4)), atol=1e-12)
    assert ops(prim) == STANDARD_OPS
    many = getattr(create_batch, kind)(count=2, position=[(1, 2, 3), (4, 5, 6)], scale=[2, 3])
    np.testing.assert_allclose(local(many[1]), compose_euler((4, 5, 6), (0, 0, 0), (3, 3, 3)), atol=1e-12)


@pytest.mark.parametrize("kind", [*SHAPES, *(light for light in LIGHTS if light != "dome_light"), "xform"])
def test_labels_and_visibility(stage, kind):
    prim = getattr(create, kind)(semantics={"class": "thing", "kind": ["a", "b"]}, visible=False)
    assert get_labels(prim) == {"class": ["thing"], "kind": ["a", "b"]}
    assert UsdGeom.Imageable(prim).ComputeVisibility() == UsdGeom.Tokens.invisible
    labels = [{"class": "a"}, [("class", "b")]]
    many = getattr(create_batch, kind)(count=2, semantics=labels, visible=[True, False])
    assert [get_labels(each)["class"] for each in many] == [["a"], ["b"]]
    assert [UsdGeom.Imageable(each).ComputeVisibility() for each in many] == ["inherited", "invisible"]


def test_look_at_several_targets_uses_their_mean_position(stage):
    balls = create_batch.sphere(count=2, position=[(0, 5, 1), (0, 5, -1)])
    camera = create.camera(look_at=balls)
    np.testing.assert_allclose(-world(camera)[2, :3], (0, 1, 0), atol=1e-12)
    assert world(camera)[1, 2] == pytest.approx(1)


def test_a_new_prim_has_the_pose_of_the_prim_it_is_relative_to(stage):
    rig = create.xform(position=(1, 0, 0), rotation=(0, 0, 90), scale=2)
    np.testing.assert_allclose(
        world(create.cube(position=(1, 0, 0), relative_to=rig)),
        compose_euler((1, 2, 0), (0, 0, 90), (2, 2, 2)),
        atol=1e-12,
    )


def test_a_pivot_is_placed_at_the_position(stage):
    cube = create.cube(pivot=(0, 0, -1))
    np.testing.assert_allclose(local(cube)[3, :3], (0, 0, 0.5), atol=1e-6)


# --- shapes ---


@pytest.mark.parametrize("kind", SHAPES)
def test_meshes_are_one_meter_across_and_aligned_with_the_up_axis(stage, y_up_stage, kind):
    size = np.diff(extent(getattr(create, kind)()), axis=0)[0]
    flat, thin = {"plane": 0, "disk": 0, "torus": 50}.get(kind, 100), {"capsule": 50, "torus": 150}.get(kind, 100)
    np.testing.assert_allclose(size, (thin, flat, thin), atol=1e-3)
    mesh = UsdGeom.Mesh(getattr(create, kind)())
    normals, indices = np.array(mesh.GetNormalsAttr().Get()), np.array(mesh.GetFaceVertexIndicesAttr().Get())
    corners = np.array(mesh.GetPointsAttr().Get())[indices].reshape(-1, 4, 3)
    facing = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (np.einsum("ni,ni->n", facing, normals.reshape(-1, 4, 3).mean(1)) >= -1e-6).all()
    if kind in ("plane", "disk"):
        np.testing.assert_allclose(normals, np.broadcast_to((0, 1, 0), normals.shape), atol=1e-6)


@pytest.mark.parametrize("kind", ["cube", "sphere", "cylinder", "cone", "capsule", "plane"])
def test_usd_shapes_have_their_default_sizes(stage, kind):
    prim = getattr(create, kind)(as_mesh=False)
    assert prim.GetTypeName() == kind.capitalize()
    plain = stage.DefinePrim("/plain", kind.capitalize())
    for name in ("size", "radius", "height", "width", "length"):
        assert prim.GetAttribute(name).Get() == plain.GetAttribute(name).Get()


def test_a_torus_that_is_not_a_mesh_raises_an_error(stage):
    with pytest.raises(Unsupported, match="as_mesh=False for torus"):
        create.torus(as_mesh=False)
    assert not stage.GetPrimAtPath("/Torus")


# --- cameras ---


def test_the_arguments_of_a_camera_reach_its_attributes(stage):
    camera = create.camera(
        focal_length=30, focus_distance=5, f_stop=1.8, horizontal_aperture=36, horizontal_aperture_offset=1,
        vertical_aperture_offset=2, clipping_range=(0.1, 100), projection_type="fisheye_polynomial",
        fisheye_nominal_width=640, fisheye_max_fov=180, fisheye_polynomial_f=0.5, openCV_focal_y=400,
        fisheye_p1=0.25, fisheye_s3=0.125, cross_camera_reference_name="left",
    )  # fmt: skip
    expected = {
        "focalLength": 30, "focusDistance": 5, "fStop": 1.8, "horizontalAperture": 36, "horizontalApertureOffset": 1,
        "verticalApertureOffset": 2, "fthetaWidth": 640, "fthetaMaxFov": 180, "fthetaPolyF": 0.5, "openCVFy": 400,
        "p1": 0.25, "s3": 0.125, "fthetaPolyB": 0.00245, "fthetaCx": 970.94244,
    }  # fmt: skip
    assert {name: camera.GetAttribute(name).Get() for name in expected} == pytest.approx(expected)
    assert camera.GetAttribute("clippingRange").Get() == Gf.Vec2f(0.1, 100)
    assert camera.GetAttribute("cameraProjectionType").Get() == "fisheyePolynomial"
    assert camera.GetAttribute("crossCameraReferenceName").Get() == "left"
    assert not create.camera().HasAttribute("crossCameraReferenceName")


@pytest.mark.parametrize("argument", OPTICS | LENS)
def test_each_number_of_a_lens_reaches_its_attribute(stage, argument):
    cameras = create_batch.camera(count=2, **{argument: [0.25, 0.75]})
    assert [camera.GetAttribute((OPTICS | LENS)[argument]).Get() for camera in cameras] == [0.25, 0.75]


def test_cameras_may_differ(stage):
    cameras = create_batch.camera(count=2, focal_length=[20, 30], clipping_range=[(1, 2), (3, 4)])
    assert [each.GetAttribute("focalLength").Get() for each in cameras] == [20, 30]
    assert [each.GetAttribute("clippingRange").Get() for each in cameras] == [Gf.Vec2f(1, 2), Gf.Vec2f(3, 4)]


def test_invalid_lenses_raise_errors(stage):
    with pytest.raises(GraphError, match="projection_type is 'fish'; expected one of pinhole"):
        create.camera(projection_type="fish")
    with pytest.raises(GraphError, match="clipping_range is 3"):
        create.camera(clipping_range=3)
    with pytest.raises(GraphError, match="focal_length is 'long'"):
        create.camera(focal_length="long")
    with pytest.warns(UsdsdgWarning, match="tick_rate is authored, but every capture"):
        made = create.camera(tick_rate=30)
    assert made.GetAttribute("omni:sensor:tickRate").Get() == 30.0
    assert not create.camera().HasAttribute("omni:sensor:tickRate")


# --- lights ---


@pytest.mark.parametrize("kind", LIGHTS)
def test_the_arguments_of_a_light_reach_its_attributes(stage, kind):
    prim = getattr(create, kind)(
        color=(1, 0.5, 0), intensity=7, exposure=2, color_temperature=3000, enable_color_temperature=True, diffuse=0.5,
        specular=0.25,
    )  # fmt: skip
    light = UsdLux.LightAPI(prim)
    assert prim.IsA(LIGHTS[kind])
    assert light.GetColorAttr().Get() == Gf.Vec3f(1, 0.5, 0)
    read = (light.GetIntensityAttr(), light.GetExposureAttr(), light.GetColorTemperatureAttr(), light.GetDiffuseAttr())
    assert [attribute.Get() for attribute in read] == [7, 2, 3000, 0.5]
    assert light.GetSpecularAttr().Get() == 0.25
    assert light.GetEnableColorTemperatureAttr().Get() is True


def test_the_defaults_of_lights(stage):
    sphere = UsdLux.LightAPI(create.sphere_light())
    assert (sphere.GetIntensityAttr().Get(), sphere.GetExposureAttr().Get()) == (30000, 0)
    assert sphere.GetEnableColorTemperatureAttr().Get() is False
    dome = UsdLux.LightAPI(create.dome_light())
    assert (dome.GetIntensityAttr().Get(), dome.GetExposureAttr().Get()) == (1000, 1)


def test_sizes_and_beams_of_lights(stage):
    assert create.sphere_light(radius=3).GetAttribute("inputs:radius").Get() == 3
    assert create.disk_light(radius=4).GetAttribute("inputs:radius").Get() == 4
    rect = create.rect_light(width=2, height=5)
    assert [rect.GetAttribute(f"inputs:{side}").Get() for side in ("width", "height")] == [2, 5]
    tube = create.cylinder_light(radius=2, length=6)
    assert [tube.GetAttribute(f"inputs:{side}").Get() for side in ("radius", "length")] == [2, 6]
    assert create.distant_light(angle=0.5).GetAttribute("inputs:angle").Get() == 0.5
    spot = create.disk_light(shaping_cone_angle=30, shaping_cone_softness=0.5, shaping_focus_tint=(1, 0, 0))
    shaping = UsdLux.ShapingAPI(spot)
    assert (shaping.GetShapingConeAngleAttr().Get(), shaping.GetShapingConeSoftnessAttr().Get()) == (30, 0.5)
    assert shaping.GetShapingFocusTintAttr().Get() == Gf.Vec3f(1, 0, 0)


def test_lights_may_differ(stage):
    lights = create_batch.sphere_light(count=2, intensity=[1, 2], color=[(1, 0, 0), (0, 1, 0)])
    assert [each.GetAttribute("inputs:intensity").Get() for each in lights] == [1, 2]
    assert lights[1].GetAttribute("inputs:color").Get() == Gf.Vec3f(0, 1, 0)


def test_the_texture_of_a_dome_light(stage, tmp_path):
    image = tmp_path / "sky.hdr"
    image.write_bytes(b"")
    dome = UsdLux.DomeLight(create.dome_light(texture=str(image), texture_format="mirroredBall"))
    assert dome.GetTextureFileAttr().Get().path == str(image)
    assert dome.GetTextureFormatAttr().Get() == "mirroredBall"
    with pytest.raises(AssetNotFound, match="no file for"):
        create.dome_light(texture=str(tmp_path / "nothing.hdr"))
    with pytest.raises(GraphError, match="texture_format is 'round'"):
        create.dome_light(texture_format="round")


# --- references and clones ---


@pytest.fixture
def file(tmp_path):
    """A USD file whose default prim has ops of its own, and a second prim."""
    made = Usd.Stage.CreateNew(str(tmp_path / "thing.usda"))
    thing = UsdGeom.Cube.Define(made, "/Thing")
    thing.AddTranslateOp().Set((1, 1, 1))
    thing.AddRotateXYZOp().Set((0, 0, 5))
    UsdGeom.Sphere.Define(made, "/Other")
    made.SetDefaultPrim(thing.GetPrim())
    made.Save()
    return str(tmp_path / "thing.usda")


def test_a_reference_keeps_the_xform_ops_of_the_referenced_prim(stage, file):
    prim = create.reference(file)
    assert str(prim.GetPath()) == "/Ref"
    assert prim.GetTypeName() == "Cube"
    np.testing.assert_allclose(local(prim), compose_euler((1, 1, 1), (0, 0, 5)), atol=1e-6)
    posed = create.reference(file, position=(2, 2, 2), scale=3, name="it", parent="/World", semantics=[("class", "x")])
    assert ops(posed) == ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    np.testing.assert_allclose(local(posed), compose_euler((2, 2, 2), (0, 0, 5), (3, 3, 3)), atol=1e-6)
    assert get_labels(posed) == {"class": ["x"]}


def test_references_to_prims(stage, file):
    assert create.reference(file, "/Other").GetTypeName() == "Sphere"
    source = create.cone(parent="/World")
    inside = create.reference(prim_path="/World/Cone", position=(1, 2, 3))
    assert inside.GetAttribute("points").Get() == source.GetAttribute("points").Get()
    both = create_batch.reference([file, file], ["/Thing", "/Other"], count=2)
    assert [prim.GetTypeName() for prim in both] == ["Cube", "Sphere"]


def test_a_reference_without_ops_gets_the_standard_ones(stage, tmp_path):
    made = Usd.Stage.CreateNew(str(tmp_path / "bare.usda"))
    made.SetDefaultPrim(made.DefinePrim("/Bare", "Xform"))
    made.Save()
    assert ops(create.reference(str(tmp_path / "bare.usda"))) == STANDARD_OPS


def test_references_and_clones_accept_the_common_arguments(stage, file):
    rig = create.xform(position=(1, 0, 0))
    labels = {"class": "x"}
    made = (
        create.reference(file, relative_to=rig, visible=False, pivot=(0, 0, -1), semantics=labels, parent="/World"),
        create.clone(create.cube(), relative_to=rig, pivot=(0, 0, -1), look_at=(1, 9, 0)),
        *create_batch.clone("/Cube", count=1, semantics=labels, visible=False, name="hidden", parent="/World"),
    )
    center = np.array([[0, 0, -1, 1], [0, 0, -0.5, 1]])
    for prim, foot in zip(made, center):
        np.testing.assert_allclose(foot @ world(prim), (1, 0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(-world(made[1])[2, :3], (0, 1, 0), atol=1e-6)
    for prim in (made[0], made[2]):
        assert get_labels(prim) == {"class": ["x"]}
        assert UsdGeom.Imageable(prim).ComputeVisibility() == "invisible"


def test_invalid_references_raise_errors(stage, file, tmp_path):
    with pytest.raises(GraphError, match="usd_path"):
        create.reference()
    with pytest.raises(AssetNotFound):
        create.reference(str(tmp_path / "none.usda"))
    with pytest.raises(AssetError, match="has no prim /Nothing"):
        create.reference(file, "/Nothing")
    headless = Usd.Stage.CreateNew(str(tmp_path / "headless.usda"))
    headless.DefinePrim("/A")
    headless.Save()
    with pytest.raises(AssetError, match=r"no default prim; pass prim_path \(it has /A\)"):
        create.reference(str(tmp_path / "headless.usda"))
    assert not stage.GetPrimAtPath("/Ref")


def test_a_clone_copies_all_descendants(stage):
    group = create.xform(name="group", position=(1, 2, 3))
    cube = create.cube(parent=group, semantics={"class": "cube"})
    material = create.material("OmniPBR.mdl", bind_prims=cube, parent=group)
    copy = create.clone("/group", name="copy", parent="/World", rotation=(0, 0, 90))
    np.testing.assert_allclose(local(copy), compose_euler((1, 2, 3), (0, 0, 90)), atol=1e-12)
    inner = copy.GetChild("Cube")
    assert get_labels(inner) == {"class": ["cube"]}
    bound, _ = UsdShade.MaterialBindingAPI(inner).ComputeBoundMaterial()
    assert str(bound.GetPath()) == "/World/copy/Material"
    cube.GetAttribute("xformOp:scale").Set(Gf.Vec3d(5))
    assert value(inner, "xformOp:scale").tolist() == [1, 1, 1]
    assert material.GetPath() == Sdf.Path("/group/Material")


def test_several_clones_have_the_opinions_of_all_layers(stage):
    cube = create.cube(position=(1, 2, 3))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        cube.GetAttribute("xformOp:scale").Set(Gf.Vec3d(2))
    copies = create_batch.clone(cube, count=2, position=[(0, 0, 1), (0, 0, 2)])
    assert [str(copy.GetPath()) for copy in copies] == ["/Cube_01", "/Cube_02"]
    np.testing.assert_allclose(local(copies[1]), compose_euler((0, 0, 2), scale=(2, 2, 2)), atol=1e-12)
    with pytest.raises(BadPrim, match="no prim /Nothing"):
        create.clone("/Nothing")


@pytest.mark.parametrize("sensor", ["omni_lidar", "omni_radar"])
def test_unsupported_sensors_raise_errors(stage, sensor):
    for module in (create, create_batch):
        with pytest.raises(Unsupported, match=f"{sensor}: .* use a camera"):
            getattr(module, sensor)()


def test_the_stub_has_the_signatures_and_docstrings_of_the_functions():
    stub = ast.parse(Path(create.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    written = {each.name: each for each in stub.body if isinstance(each, ast.FunctionDef)}
    # A module that scripts import under a foreign name gets a `__getattr__` that explains missing names.
    public = [name for name in vars(create_batch) if not name.startswith("_") and name != "name_parameters"]
    made = {name for name in public if inspect.isfunction(getattr(create, name, None))}
    assert written.keys() == made
    for name, definition in written.items():
        function = getattr(create, name)
        definition.body[1:] = []
        namespace: dict = {"Any": Any, "Usd": Usd}
        exec(ast.unparse(definition), namespace)
        assert inspect.signature(namespace[name]) == inspect.signature(function)
        assert namespace[name].__doc__ == function.__doc__


def test_one_prim_takes_no_more_positional_arguments_than_its_signature_has(stage):
    assert create.scope("Parts", None).GetName() == "Parts"
    with pytest.raises(TypeError, match=r"scope\(\) takes 2 positional arguments, not 3"):
        create.scope("Parts", None, 1)
    with pytest.raises(TypeError, match="multiple values for keyword argument 'name'"):
        create.scope("Parts", name="Others")


def test_arguments_in_order_are_those_of_replicator(stage):
    # omni.replicator.core 1.12.27, functional/create.py and create_batch.py.
    red = create.material("OmniPBR.mdl", None, "Red")
    placed = ((1, 2, 3), 2, (0, 0, 90), None, None, None, None, {"class": "part"}, False)
    inside = ("inner", "/group")

    group = create.xform(*placed, "group", None, red)
    light = create.rect_light(*placed, (1, 0, 0), 5, 6, 3000, True, 0.5, 0.25, 30, 0.75, (0, 1, 0), 7, 8, *inside)
    tube = create.cylinder(*placed[:-1], False, False, "tube", "/group", red)
    balls = create_batch.sphere(*placed, False, 2, "ball", "/group", red)
    sheets = create_batch.plane(*placed, 2, "sheet", "/group", red)
    copied = create.clone(group, *placed[:7], "copy", None)
    sky = create.dome_light((1, 0, 0), None, "angular", 5, 6, 0.5, 0.25, 3000, True, *placed[:5], "sky", "/group")
    skies = create_batch.dome_light(*placed[:5], (1, 0, 0), None, "angular", 5, 6, 0.5, 0.25, 3000, True, 2, "sky")

    assert [str(prim.GetPath()) for prim in (group, light, tube, *balls, *sheets, copied, sky, *skies)] == [
        "/group", "/group/inner", "/group/tube", "/group/ball", "/group/ball_01", "/group/sheet", "/group/sheet_01",
        "/copy", "/group/sky", "/sky", "/sky_01",
    ]  # fmt: skip
    np.testing.assert_allclose(local(sky), compose_euler((1, 2, 3), (0, 0, 90), (2, 2, 2)), atol=1e-6)
    np.testing.assert_allclose(local(copied), local(group), atol=1e-6)
    assert [prim.GetTypeName() for prim in (tube, *balls, *sheets)] == ["Cylinder", "Sphere", "Sphere", "Mesh", "Mesh"]
    assert get_labels(group) == get_labels(light) == {"class": ["part"]}
    assert all(value(prim, "visibility") == "invisible" for prim in (group, light, tube, *balls))
    for prim in (group, tube, *balls, *sheets):
        assert UsdShade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterialPath() == red.GetPath()
    assert [value(light, f"inputs:{name}") for name in ("intensity", "diffuse", "height", "width")] == [5, 0.5, 7, 8]
    for prim in (light, sky, *skies):
        assert (value(prim, "inputs:exposure"), value(prim, "inputs:colorTemperature")) == (6, 3000)
