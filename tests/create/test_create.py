"""Materials, cameras and layers that `rep.create` and `new_layer` author."""

import numpy as np
import pytest
from PIL import Image
from pxr import Sdf, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.app import new_layer
from usdsdg.errors import AssetNotFound, BadPrim, GraphError, Unsupported, UsdsdgWarning
from usdsdg.graph import evaluate
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.semantics import labels


def shader_of(stage, path):
    return UsdShade.Material(stage.GetPrimAtPath(path)).ComputeSurfaceSource("mdl")[0].GetPrim()


def test_omnipbr_writes_the_inputs_that_are_given(stage, tmp_path):
    image = tmp_path / "wood.png"
    image.write_bytes(b"")
    item = rep.create.material_omnipbr(
        diffuse=(0.1, 0.2, 0.3), roughness=[0.2, 0.8], metallic=1.0, roughness_texture=str(image),
        emissive_color=(1, 0, 0), emissive_intensity=500, project_uvw=True, semantics=[("material", "wood")], count=2,
    )  # fmt: skip
    assert item.prims == ("/Replicator/Looks/OmniPBR", "/Replicator/Looks/OmniPBR_01")
    for path, roughness in zip(item.prims, (0.2, 0.8)):
        shader = shader_of(stage, path)
        values = {a.GetName().removeprefix("inputs:"): a.Get() for a in shader.GetAuthoredAttributes()}
        assert np.allclose(values["diffuse_color_constant"], (0.1, 0.2, 0.3))
        assert values["reflection_roughness_constant"] == pytest.approx(roughness)
        assert values["reflectionroughness_texture"].path == str(image)
        assert values["reflection_roughness_texture_influence"] == 1.0
        assert (values["metallic_constant"], values["enable_emission"], values["project_uvw"]) == (1.0, True, True)
        assert values["emissive_intensity"] == 500
        assert "specular_level" not in values
        preview = stage.GetPrimAtPath(f"{path}/PreviewSurface")
        assert np.allclose(preview.GetAttribute("inputs:diffuseColor").Get(), (0.1, 0.2, 0.3))
        assert labels.get_labels(stage.GetPrimAtPath(path)) == {"material": ["wood"]}


@pytest.mark.parametrize(
    ("argument", "value", "name", "held"),
    [
        ("diffuse", (0.25, 0.5, 1), "diffuse_color_constant", (0.25, 0.5, 1)),
        ("roughness", 0.25, "reflection_roughness_constant", 0.25),
        ("metallic", 0.5, "metallic_constant", 0.5),
        ("specular", 0.75, "specular_level", 0.75),
        ("emissive_color", (1, 0, 0.5), "emissive_color", (1, 0, 0.5)),
        ("emissive_intensity", 40, "emissive_intensity", 40),
        ("project_uvw", True, "project_uvw", True),
    ],
)
def test_each_constant_of_omnipbr_reaches_its_input(stage, argument, value, name, held):
    one = shader_of(stage, rep.create.material_omnipbr(**{argument: value}).prims[0])
    assert one.GetAttribute(f"inputs:{name}").Get() == held
    assert one.GetAttribute("inputs:enable_emission").Get() is True
    assert one.GetAttribute("inputs:emissive_intensity").Get() == (value if argument == "emissive_intensity" else 0)
    drawn = rep.create.material_omnipbr(**{argument: rep.distribution.choice([value])}, count=2)
    evaluate.graph().evaluate()
    assert [shader_of(stage, path).GetAttribute(f"inputs:{name}").Get() for path in drawn.prims] == [held, held]


@pytest.mark.parametrize(
    ("argument", "name"),
    [
        ("diffuse_texture", "diffuse_texture"),
        ("roughness_texture", "reflectionroughness_texture"),
        ("metallic_texture", "metallic_texture"),
        ("emissive_texture", "emissive_color_texture"),
    ],
)
def test_each_texture_of_omnipbr_reaches_its_input(stage, tmp_path, argument, name):
    (tmp_path / "wood.png").write_bytes(b"")
    item = rep.create.material_omnipbr(**{argument: str(tmp_path / "wood.png")})
    shader = shader_of(stage, item.prims[0])
    assert shader.GetAttribute(f"inputs:{name}").Get().path == str(tmp_path / "wood.png")
    if argument in ("roughness_texture", "metallic_texture"):
        influence = {"roughness_texture": "reflection_roughness", "metallic_texture": "metallic"}[argument]
        assert shader.GetAttribute(f"inputs:{influence}_texture_influence").Get() == 1


def test_a_material_can_begin_to_glow_later(stage):
    glowing, dark = rep.create.material_omnipbr(), rep.create.material_omnipbr(emissive_intensity=None)
    rep.modify.attribute("emissive_intensity", 100.0, input_prims=glowing)
    evaluate.graph().evaluate()
    one, other = (shader_of(stage, item.prims[0]) for item in (glowing, dark))
    assert one.GetAttribute("inputs:enable_emission").Get() is True
    assert one.GetAttribute("inputs:emissive_intensity").Get() == 100
    assert not other.HasAttribute("inputs:enable_emission")


def test_omnipbr_inputs_are_sampled_at_every_firing_and_the_material_can_be_bound(stage):
    with rep.trigger.on_custom_event("go"):
        materials = rep.create.material_omnipbr(diffuse=rep.distribution.uniform((0, 0, 0), (1, 1, 1)), count=4)
    cubes = rep.create.cube(count=2, material=materials.prims[0])
    seen = []
    for _ in range(2):
        rep.utils.send_og_event("go")
        evaluate.graph().evaluate()
        for path in materials.prims:
            seen.append(tuple(shader_of(stage, path).GetAttribute("inputs:diffuse_color_constant").Get()))
    assert len(set(seen)) == 8
    bound = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(cubes.prims[1])).ComputeBoundMaterial()[0]
    assert str(bound.GetPath()) == materials.prims[0]


def test_invalid_omnipbr_arguments_raise_errors(stage):
    with pytest.raises(AssetNotFound):
        rep.create.material_omnipbr(diffuse_texture="/nowhere/wood.png")
    with pytest.raises(ValueError, match="diffuse_color_constant"):
        rep.create.material_omnipbr(diffuse=(1, 2))
    with pytest.raises(Unsupported, match="material_omnipbr"):
        rep.create.mdl_from_json({})


@pytest.mark.parametrize(
    ("up_axis", "arguments", "ahead", "upward"),
    [
        # Replicator's own tests have these rotations and targets.
        ("Z", {}, (-1, 0, 0), (0, 0, 1)),
        ("Z", {"rotation": (0, 0, -90)}, (0, 1, 0), (0, 0, 1)),
        ("Z", {"rotation": (0, -90, 0)}, (0, 0, -1), (-1, 0, 0)),
        ("Z", {"position": (0, 0, 500), "look_at": (0, 0, 100)}, (0, 0, -1), (-1, 0, 0)),
        ("Y", {}, (0, 0, -1), (0, 1, 0)),
        ("Y", {"rotation": (0, -90, 0)}, (1, 0, 0), (0, 1, 0)),
        ("Y", {"position": (0, 500, 0), "look_at": (0, 100, 0)}, (0, -1, 0), (0, 0, -1)),
    ],
)
def test_cameras_look_where_those_of_replicator_do(stage, up_axis, arguments, ahead, upward):
    UsdGeom.SetStageUpAxis(stage, up_axis)
    (path,) = rep.create.camera(**arguments).prims
    axes = read_camera(stage, path, (8, 8)).local_to_world[:3, :3]
    np.testing.assert_allclose(-axes[2], ahead, atol=1e-6)
    np.testing.assert_allclose(axes[1], upward, atol=1e-6)


def eyes(stage, pair):
    """The views of the left and the right camera of each pair of an item."""
    paths = [f"{each}/{each.split('/')[-1].removesuffix('_01')}" for each in pair.prims]
    ends = [f"{path}_{side}_Xform/{path.split('/')[-1]}_{side}" for path in paths for side in "LR"]
    return [read_camera(stage, path, (64, 48)) for path in ends]


def test_the_left_camera_of_a_z_up_stage_is_at_minus_y(stage):
    left, right = eyes(stage, rep.create.stereo_camera(0.5, name="eye"))
    np.testing.assert_allclose([left.local_to_world[3, 1], right.local_to_world[3, 1]], [-0.25, 0.25], atol=1e-9)


def test_cameras_of_a_stereo_pair_are_parallel_and_a_baseline_apart(stage):
    pair = rep.create.stereo_camera(0.2, position=(1, 2, 3), look_at=(5, 2, 3), focal_length=30)
    assert pair.prims == ("/Replicator/StereoCam",)
    left, right = eyes(stage, pair)
    assert left.focal_length == right.focal_length == 30
    # Seen by the left camera, the right one is on its right.
    between = np.array(right.local_to_world)[3] @ left.world_to_camera
    np.testing.assert_allclose(between[:3], (0.2, 0, 0), atol=1e-6)
    np.testing.assert_allclose(left.local_to_world[:3, :3], right.local_to_world[:3, :3], atol=1e-9)
    np.testing.assert_allclose(-left.local_to_world[2, :3], (1, 0, 0), atol=1e-6)
    center = (left.local_to_world[3, :3] + right.local_to_world[3, :3]) / 2
    np.testing.assert_allclose(center, (1, 2, 3), atol=1e-6)


def test_render_products_of_stereo_pairs_are_of_both_cameras(stage):
    pair = rep.create.stereo_camera(0.2, name="rig")

    def cameras(products):
        return [each.camera_path for each in products]

    found = rep.create.render_product(pair, (64, 48))
    assert cameras(found) == [f"/Replicator/rig/rig_{side}_Xform/rig_{side}" for side in "LR"]
    many = rep.create.render_product([rep.create.stereo_camera(0.2, count=2), rep.create.camera()], (64, 48))
    assert [path[-2:] for path in cameras(many)] == ["_L", "_R", "_L", "_R", "ra"]
    holder = UsdGeom.Xform.Define(stage, "/World/Holder")
    for name in ("first", "second"):
        UsdGeom.Camera.Define(stage, f"/World/Holder/{name}")
    assert cameras([rep.create.render_product(str(holder.GetPath()), (64, 48))]) == ["/World/Holder/first"]


def test_stereo_pairs_have_parents_and_numbers(stage):
    pairs = rep.create.stereo_camera(1.0, parent="/World", position=[(0, 0, 1), (0, 0, 2)], count=2)
    assert pairs.prims == ("/World/StereoCam", "/World/StereoCam_01")
    places = np.array([view.local_to_world[3, :3] for view in eyes(stage, pairs)])
    np.testing.assert_allclose(places, [(0, y, z) for z in (1, 2) for y in (-0.5, 0.5)], atol=1e-9)
    with pytest.raises(BadPrim, match="/Wrld"):
        rep.create.stereo_camera(1.0, parent="/Wrld")


def test_a_stereo_pair_of_a_y_up_stage(stage):
    UsdGeom.SetStageUpAxis(stage, "Y")
    left, right = eyes(stage, rep.create.stereo_camera(0.5, name="eye"))
    assert (right.local_to_world[3, 0], left.local_to_world[3, 0]) == (0.25, -0.25)
    with pytest.raises(GraphError, match="stereo_baseline is 'wide'"):
        rep.create.stereo_camera("wide")


def test_products_of_a_pair_are_called_left_and_right(stage):
    def names(*arguments, **keywords):
        return [each.path.split("/")[-1] for each in rep.create.render_product(*arguments, (64, 48), **keywords)]

    pair = rep.create.stereo_camera(0.2)
    assert names(pair) == names(pair) == ["Replicator_L", "Replicator_R"]
    assert names(pair, force_new=True) == ["Replicator_L_01", "Replicator_R_01"]
    assert names(pair, name="eye") == ["eye", "eye_01"]
    assert names(pair, name=["port", "starboard"]) == ["port", "starboard"]
    # As in Replicator, the path says whether cameras are a pair.
    assert names(rep.create.stereo_camera(0.2, name="rig")) == ["Replicator", "Replicator_01"]


def test_cameras_of_a_fisheye_pair_refer_to_each_other(stage):
    def partners(pair):
        cameras = [stage.GetPrimAtPath(each.prim_path) for each in eyes(stage, pair)]
        return [camera.GetAttribute("crossCameraReferenceName").Get() for camera in cameras]

    lens = "fisheye_polynomial"
    pairs = rep.create.stereo_camera(0.2, projection_type=lens, count=2)
    assert partners(pairs) == ["StereoCam_R", "StereoCam_L"] * 2
    assert partners(rep.create.stereo_camera(0.2, projection_type=lens, name="a")) == ["a_R", "a_L"]
    named = rep.create.stereo_camera(0.2, projection_type=lens, name="b", cross_camera_reference_name="a_L")
    assert partners(named) == ["a_L", "a_L"]
    left = rep.create.stereo_camera(0.2, name="c").get_output_prims()["prims"][0].GetChildren()[0].GetChildren()[0]
    assert str(left.GetPath()) == "/Replicator/c/c_L_Xform/c_L"
    assert not left.HasAttribute("crossCameraReferenceName")


@pytest.mark.parametrize("name", ["fisheyePolynomial", "fisheye_polynomial"])
def test_other_lenses_are_authored(stage, name):
    item = rep.create.camera(projection_type=name, fisheye_polynomial_b=0.003, fisheye_max_fov=180)
    prim = stage.GetPrimAtPath(f"{item.prims[0]}/Camera")
    values = {name: prim.GetAttribute(name).Get() for name in ("cameraProjectionType", "fthetaMaxFov", "fthetaPolyB")}
    assert values == {
        "cameraProjectionType": "fisheyePolynomial",
        "fthetaMaxFov": 180,
        "fthetaPolyB": pytest.approx(0.003),
    }
    assert read_camera(stage, prim.GetPath(), (8, 8)).projection_type == "fisheyePolynomial"


def test_lens_models_whose_attributes_are_not_arguments(stage):
    item = rep.create.camera(projection_type="omni_directional_stereo")
    prim = stage.GetPrimAtPath(f"{item.prims[0]}/Camera")
    assert prim.GetAttribute("cameraProjectionType").Get() == "omniDirectionalStereo"
    prim.CreateAttribute("isLeftEye", Sdf.ValueTypeNames.Bool).Set(True)
    view = read_camera(stage, prim.GetPath(), (8, 8))
    assert view.lens is not None
    assert view.lens.eye_offset == pytest.approx(-0.032 / view.meters_per_unit)


def test_unknown_lens_models_raise_errors(stage):
    with pytest.raises(GraphError, match="projection_type is 'wide'; expected one of pinhole"):
        rep.create.camera(projection_type="wide")
    with pytest.warns(UsdsdgWarning, match="tick_rate is authored, but every capture"):
        (prim,) = rep.create.camera(tick_rate=30).get_output_prims()["prims"]
    assert prim.GetChildren()[0].GetAttribute("omni:sensor:tickRate").Get() == 30.0
    with pytest.raises(GraphError, match="tick_rate is 'fast'"):
        rep.create.camera(tick_rate="fast")


def test_functions_of_scripts_can_be_registered_in_create(stage):
    def tower(height):
        return rep.create.cube(count=height, position=[(0, 0, z) for z in range(height)])

    rep.create.register(tower, fn_name="block_tower")
    assert len(rep.create.block_tower(4).prims) == 4
    del rep.create.block_tower


def test_a_new_layer_has_the_prims_of_a_script_and_is_cleared_by_the_next_run(stage):
    for _ in range(2):
        with new_layer.new_layer():
            cubes = rep.create.cube(count=2)
            with rep.trigger.on_frame():
                rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)), input_prims=cubes)
        assert cubes.prims == ("/Replicator/Cube_Xform", "/Replicator/Cube_Xform_01")
    assert stage.GetEditTarget().GetLayer() == stage.GetRootLayer()
    (identifier,) = stage.GetRootLayer().subLayerPaths
    assert Sdf.Layer.Find(identifier).GetPrimAtPath("/Replicator/Cube_Xform")
    assert not stage.GetRootLayer().GetPrimAtPath("/Replicator")
    assert len(evaluate.graph().triggers) == 1
    for _ in range(2):
        with new_layer.new_layer("Mine") as layer:
            assert layer.GetDisplayName() == "Mine"
    assert [Sdf.Layer.Find(each).GetDisplayName() for each in stage.GetRootLayer().subLayerPaths] == [
        "Mine", "Replicator",
    ]  # fmt: skip


def test_a_script_that_runs_again_after_frames_has_the_same_paths_and_draws(stage):
    """As a cell of a notebook, or a test of a suite that keeps its stage."""
    own = stage.DefinePrim("/Replicator/Mine/Kept", "Xform")  # of the user, in the root layer
    seen = []
    for _ in range(2):
        with new_layer.new_layer():
            cubes = rep.create.cube(count=2)
            with rep.trigger.on_frame():
                rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)), input_prims=cubes)
        rep.set_global_seed(3)
        rep.orchestrator.step()
        rep.orchestrator.step()
        rep.orchestrator.stop()
        places = [prim.GetAttribute("xformOp:translate").Get() for prim in cubes.get_output_prims()["prims"]]
        seen.append((cubes.prims, places))
    assert seen[0] == seen[1]
    assert seen[0][0] == ("/Replicator/Cube_Xform", "/Replicator/Cube_Xform_01")
    assert own.IsValid()
    with new_layer.new_layer():
        assert [prim.GetName() for prim in stage.GetPrimAtPath("/Replicator").GetAllChildren()] == ["Mine"]


def test_an_error_in_a_layer_is_raised(stage):
    with pytest.raises(GraphError, match="count is -1"), new_layer.new_layer():
        rep.create.cube(count=-1)
    assert stage.GetEditTarget().GetLayer() == stage.GetRootLayer()


@pytest.mark.parametrize("usd", [["a.usd", "b.usd"], rep.distribution.choice])
def test_a_reference_to_several_files_names_what_draws_from_them(stage, usd):
    usd = usd if isinstance(usd, list) else usd(["a.usd", "b.usd"])
    with pytest.raises(GraphError, match=r"usd is .* randomizer\.instantiate\(paths, size\) draws from several"):
        rep.create.from_usd(usd)


@pytest.mark.parametrize("function", [rep.create.cube, rep.create.camera, rep.create.light])
def test_a_rotation_beside_a_direction_to_look_is_warned_of(stage, function):
    with pytest.warns(UsdsdgWarning, match=rf"{function.__name__}: rotation and look_at exclude each other"):
        function(position=(1, 0, 0), look_at=(0, 0, 0), rotation=(0, 0, 45))


def test_names_of_prims_that_an_item_does_not_have_are_answered_with_its_prims(stage):
    item = rep.create.cube()
    with pytest.raises(AttributeError, match=r"'ReplicatorItem' .* 'GetAttribute'; .* item\.get_output_prims\(\)"):
        item.GetAttribute("points")
    with pytest.raises(AttributeError, match=r"'position'$"):
        _ = item.position
    assert not hasattr(item, "IsA")


@pytest.fixture
def folder(tmp_path):
    """A folder with two assets, a picture and a material."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.usda").write_text('#usda 1.0\n(\n    defaultPrim = "C"\n)\ndef Cube "C"\n{\n}\n')
    Image.new("RGB", (2, 2)).save(tmp_path / "sky.png")
    return tmp_path


@pytest.mark.parametrize(
    "call",
    [
        lambda folder: rep.create.from_dir(folder).get_output_prims()["prims"],
        lambda folder: rep.create.from_usd(folder / "a.usda").get_output_prims()["prims"],
        lambda folder: rep.utils.get_usd_files(folder),
        lambda folder: rep.randomizer.instantiate([folder / "a.usda"], size=1).get_input("paths").get_input("choices"),
        lambda folder: rep.distribution.choice([folder / "a.usda"]).get_input("choices"),
        lambda folder: rep.create.light(light_type="Dome", texture=rep.distribution.choice([folder / "sky.png"])).prims,
    ],
)
def test_files_may_be_paths_of_pathlib(folder, call):
    class Text(str):
        """A folder as text, of which files are text."""

        def __truediv__(self, name):
            return Text(f"{self}/{name}")

    def made(place):
        new_stage()
        return [str(each) for each in call(place)]

    assert made(folder) == made(Text(folder))


def test_missing_folders_that_are_paths_of_pathlib_are_named(stage, tmp_path):
    for call in (rep.create.from_dir, rep.utils.get_usd_files):
        with pytest.raises(AssetNotFound, match="nowhere"):
            call(tmp_path / "nowhere")
    with pytest.raises(AssetNotFound, match="nowhere"):
        rep.randomizer.instantiate([tmp_path / "nowhere.usd"], size=1)
