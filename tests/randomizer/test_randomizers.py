"""Rotations, colors, textures and materials that `rep.randomizer` writes to the stage."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdShade
from scipy import stats

import usdsdg as rep
from usdsdg.errors import AssetNotFound, BadPrim, GraphError, UsdsdgWarning
from usdsdg.graph import evaluate
from usdsdg.session import stage_context
from usdsdg.stage import assets


def fire():
    rep.utils.send_og_event("go")
    evaluate.graph().evaluate()


def drawn(make, seed=1):
    """Return the values that a randomizer of forty cubes writes in two firings on a new stage."""
    stage = stage_context.new_stage()
    rep.set_global_seed(seed)
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=40) as cubes:
        read = make(stage, cubes)
    found = []
    for _ in range(2):
        fire()
        found.append([read(stage.GetPrimAtPath(path)) for path in cubes.prims])
    return found


def material_inputs(prim):
    """Return the inputs of the MDL shader bound to a prim."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    shader = bound.ComputeSurfaceSource("mdl")[0]
    return {each.GetBaseName(): each.Get() for each in shader.GetInputs()}


# --- rotations ---


def angles(prim):
    return tuple(prim.GetAttribute("xformOp:rotateXYZ").Get())


def rotated(**arguments):
    def make(stage, cubes):
        rep.randomizer.rotation(**arguments)
        return angles

    return make


def test_angles_are_uniform_within_their_bounds():
    lower, upper = (0, -90, 5), (45, 90, 5)
    found = np.array(drawn(rotated(min_angle=lower, max_angle=upper))).reshape(-1, 3)
    for axis in (0, 1):
        fraction = (found[:, axis] - lower[axis]) / (upper[axis] - lower[axis])
        assert stats.kstest(fraction, "uniform").pvalue > 1e-4
    assert (found[:, 2] == 5).all()
    assert len(np.unique(found[:, 0])) == 80
    one = np.array(drawn(rotated(min_angle=10, max_angle=20)))
    assert ((one >= 10) & (one <= 20)).all()


def test_by_default_directions_are_uniform_on_the_sphere():
    def axis(prim):
        return np.array(UsdGeom.Xformable(prim).GetLocalTransformation())[0, :3]

    def make(stage, cubes):
        rep.randomizer.rotation()
        return axis

    # Archimedes: each coordinate of a uniform direction is uniform from -1 to 1.
    directions = np.array(drawn(make)).reshape(-1, 3)
    for coordinate in directions.T:
        assert stats.kstest((coordinate + 1) / 2, "uniform").pvalue > 1e-4


def test_a_seed_of_rotations_replaces_the_global_one():
    own = drawn(rotated(seed=7), seed=1)
    assert drawn(rotated(seed=7), seed=2) == own
    assert drawn(rotated(), seed=7) == own
    assert drawn(rotated(seed=-1), seed=2) == drawn(rotated(), seed=2) != drawn(rotated(), seed=1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"min_angle": (10, 0, 0), "max_angle": (1, 1, 1)}, r"min_angle=\(10, 0, 0\) is above max_angle=\(1, 1, 1\)"),
        ({"min_angle": (0, 0)}, r"min_angle is \(0, 0\); expected three numbers"),
        ({"max_angle": "much"}, "max_angle is 'much'; expected three numbers"),
        ({"seed": "x"}, "seed is 'x'; expected a whole number"),
    ],
)
def test_invalid_rotation_bounds_raise_errors(stage, arguments, message):
    with pytest.raises(GraphError, match=message):
        rep.randomizer.rotation(**arguments, input_prims=rep.create.cube())


# --- colors ---


@pytest.fixture
def pair(stage):
    """An object of two meshes."""
    group = rep.create.xform(name="pair")
    for name in "ab":
        rep.create.cube(parent=group, name=name)
    return group


def meshes(stage, pair):
    return [stage.GetPrimAtPath(f"{pair.prims[0]}/{name}_Xform/{name}") for name in "ab"]


def test_meshes_share_a_color_unless_per_sub_mesh_is_set(stage, pair):
    with rep.trigger.on_custom_event("go"):
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)), input_prims=pair)
    fire()
    one, other = (material_inputs(mesh)["diffuse_color_constant"] for mesh in meshes(stage, pair))
    assert one == other
    assert len(stage.GetPrimAtPath("/Replicator/Looks").GetChildren()) == 1


def test_each_mesh_may_get_its_own_material(stage, pair):
    with rep.trigger.on_custom_event("go"):
        rep.randomizer.color([(1, 0, 0)], per_sub_mesh=True, input_prims=pair)
    fire()
    fire()
    bound = [UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0].GetPath() for mesh in meshes(stage, pair)]
    assert [str(path) for path in bound] == ["/Replicator/Looks/OmniPBR", "/Replicator/Looks/OmniPBR_01"]
    assert [material_inputs(mesh)["diffuse_color_constant"] for mesh in meshes(stage, pair)] == [(1, 0, 0)] * 2


def test_each_mesh_draws_a_color_and_a_texture_of_its_own(stage, images):
    UsdGeom.Xform.Define(stage, "/Kind")
    parts = [f"part{index}" for index in range(8)]
    for part in parts:
        UsdGeom.Cube.Define(stage, f"/Kind/{part}")
    for name in ("one", "other"):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        prim.GetReferences().AddInternalReference("/Kind")
        prim.SetInstanceable(True)
    both = rep.get.prims(path_pattern="/World/(one|other)$")
    meshes = [f"/World/{name}/{part}" for name in ("one", "other") for part in parts]
    with rep.trigger.on_custom_event("go"), both:
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)), per_sub_mesh=True)
    fire()
    colors = [tuple(material_inputs(stage.GetPrimAtPath(path))["diffuse_color_constant"]) for path in meshes]
    assert len(set(colors)) == 16
    fire()
    again = [tuple(material_inputs(stage.GetPrimAtPath(path))["diffuse_color_constant"]) for path in meshes]
    assert not set(colors) & set(again)

    rep.randomizer.texture(images, per_sub_mesh=True, texture_rotate=[10, 20], input_prims=both)
    evaluate.graph().evaluate()
    found = [material_inputs(stage.GetPrimAtPath(path)) for path in meshes]
    assert [inputs["texture_rotate"] for inputs in found] == [10] * 8 + [20] * 8
    assert len({inputs["diffuse_texture"].path for inputs in found[:8]}) > 1


def test_an_instance_becomes_an_ordinary_prim_when_colored(stage):
    source, copy = rep.create.cube(), stage.DefinePrim("/World/copy")
    copy.GetReferences().AddInternalReference(source.prims[0])
    copy.SetInstanceable(True)
    rep.randomizer.color((0, 1, 0), input_prims="/World/copy")
    evaluate.graph().evaluate()
    assert not copy.IsInstance()
    assert material_inputs(copy.GetChild("Cube"))["diffuse_color_constant"] == (0, 1, 0)


# --- textures ---


@pytest.fixture
def images(tmp_path):
    paths = [str(tmp_path / f"{name}.png") for name in ("wood", "stone", "rust")]
    for path in paths:
        open(path, "wb").close()
    return paths


def textured(images, **arguments):
    def make(stage, cubes):
        rep.randomizer.texture(images, **arguments)
        return lambda prim: material_inputs(prim)["diffuse_texture"].path

    return make


def test_random_textures_repeat_with_their_seed(images):
    found = drawn(textured(images, seed=3), seed=1)
    assert set(found[0]) == set(images)
    assert found[0] != found[1]
    assert drawn(textured(images, seed=3), seed=2) == found
    assert drawn(textured(images), seed=3) == found
    assert drawn(textured(images, seed=4), seed=1) != found


def test_textures_are_scaled_rotated_and_projected(stage, images):
    cubes = rep.create.cube(count=2)
    with rep.trigger.on_custom_event("go"):
        rep.randomizer.texture(
            rep.distribution.sequence(images, stride=2), texture_scale=[(2, 3), (4, 5)],
            texture_rotate=rep.distribution.uniform(30, 60), project_uvw=True, input_prims=cubes,
        )  # fmt: skip
    fire()
    materials = [material_inputs(stage.GetPrimAtPath(path)) for path in cubes.prims]
    assert [inputs["diffuse_texture"].path for inputs in materials] == images[:2]
    assert [inputs["texture_scale"] for inputs in materials] == [(2, 3), (4, 5)]
    assert all(30 <= inputs["texture_rotate"] < 60 and inputs["project_uvw"] is True for inputs in materials)
    plain = rep.create.cube()
    rep.randomizer.texture(images[:1], texture_scale=2, texture_rotate=90, input_prims=plain)
    evaluate.graph().evaluate()
    inputs = material_inputs(stage.GetPrimAtPath(plain.prims[0]))
    assert (inputs["texture_scale"], inputs["texture_rotate"]) == ((2, 2), 90)
    assert "project_uvw" not in inputs


@pytest.mark.parametrize(("turns", "found"), [([10, 20, 30], [10, 20, 30]), ([45], [45, 45, 45])])
def test_lists_of_a_textures_values_are_one_for_all_or_one_for_each(stage, images, turns, found):
    cubes = rep.create.cube(count=3)
    rep.randomizer.texture(images[:1], texture_scale=[(0.5, 2)], texture_rotate=turns, input_prims=cubes)
    evaluate.graph().evaluate()
    materials = [material_inputs(stage.GetPrimAtPath(path)) for path in cubes.prims]
    assert [inputs["texture_rotate"] for inputs in materials] == found
    assert [inputs["texture_scale"] for inputs in materials] == [(0.5, 2)] * 3


def test_lists_of_a_textures_values_with_another_length_are_an_error(stage, images):
    rep.randomizer.texture(images[:1], texture_rotate=[1, 2], input_prims=rep.create.cube(count=3))
    with pytest.raises(GraphError, match="texture_rotate has 2 values for 3 prims"):
        evaluate.graph().evaluate()


def test_each_mesh_may_get_a_texture(stage, pair, images):
    rep.randomizer.texture(images[:1], per_sub_mesh=True, input_prims=pair)
    evaluate.graph().evaluate()
    assert [material_inputs(mesh)["diffuse_texture"].path for mesh in meshes(stage, pair)] == images[:1] * 2
    assert len(stage.GetPrimAtPath("/Replicator/Looks").GetChildren()) == 2


def test_missing_textures_raise_errors(stage, images):
    cube = rep.create.cube()
    wrong = images[0].replace("wood", "woood")
    with pytest.raises(AssetNotFound, match=r"did you mean wood\.png"):
        rep.randomizer.texture([*images, wrong], input_prims=cube)
    with pytest.raises(GraphError, match=r"choices is '.*; expected a list"):
        rep.randomizer.texture(wrong, input_prims=cube)
    rep.randomizer.texture(rep.distribution.sequence([wrong]), input_prims=cube)
    with pytest.raises(GraphError, match=r"test_randomizers\.py:\d+\).*did you mean wood\.png"):
        evaluate.graph().evaluate()


# --- materials ---


def with_material(**arguments):
    def make(stage, cubes):
        materials = rep.create.material_omnipbr(count=3)
        rep.randomizer.materials(
            [materials.prims[0], stage.GetPrimAtPath(materials.prims[1]), materials.prims[2]], **arguments
        )
        return lambda prim: str(UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath())

    return make


def test_random_materials_repeat_with_their_seed():
    found = drawn(with_material(seed=3), seed=1)
    assert set(found[0]) == {f"/Replicator/Looks/OmniPBR{number}" for number in ("", "_01", "_02")}
    assert found[0] != found[1]
    assert drawn(with_material(seed=3, max_cached_materials=2), seed=2) == found
    assert drawn(with_material(), seed=3) == found
    assert drawn(with_material(seed=4), seed=1) != found


def _red_mdl(folder):
    file = folder / "NVIDIA" / "Materials" / "Red.mdl"
    file.parent.mkdir(parents=True)
    red = "export material Red(*) = ::OmniPBR::OmniPBR(diffuse_color_constant: color(1.f, 0.f, 0.f));"
    file.write_text(f"mdl 1.4;\nimport ::OmniPBR::OmniPBR;\n{red}\n")
    return file


@pytest.mark.parametrize("given", [list, rep.distribution.choice])
def test_materials_are_made_from_mdl_files(stage, tmp_path, monkeypatch, given):
    file = _red_mdl(tmp_path)
    monkeypatch.setenv(assets.ROOT_VARIABLE, str(tmp_path))
    cubes = rep.create.cube(count=2)
    rep.randomizer.materials(given(["/NVIDIA/Materials/Red.mdl"]), input_prims=cubes)
    rep.randomizer.materials([str(file)], input_prims=cubes)
    evaluate.graph().evaluate()
    for path in cubes.prims:
        material, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)).ComputeBoundMaterial()
        assert material.GetPath() == "/Replicator/Looks/Red"
        shader = material.ComputeSurfaceSource("mdl")[0]
        assert (shader.GetSourceAsset("mdl").path, shader.GetSourceAssetSubIdentifier("mdl")) == (str(file), "Red")
    with pytest.raises(AssetNotFound, match="Blue"):
        rep.randomizer.materials(["/NVIDIA/Materials/Blue.mdl"], input_prims=cubes)


def test_an_mdl_file_is_rendered_as_the_template_that_it_calls(stage, tmp_path):
    rep.create.light(light_type="Dome", intensity=1000)
    product = rep.create.render_product(rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0)), (16, 12))
    rgb = rep.annotators.get("rgb").attach(product)
    strange = tmp_path / "Strange.mdl"
    strange.write_text("mdl 1.4;\nexport material Strange() = material();\n")
    with rep.create.cube() as cube:
        rep.randomizer.materials([str(strange)])
    with pytest.warns(UsdsdgWarning, match=f"'Strange of {strange}' is not supported"):
        rep.orchestrator.step()
    with cube:
        rep.randomizer.materials([str(_red_mdl(tmp_path))])
    rep.orchestrator.step()
    red, green, blue, _ = rgb.get_data()[6, 8].astype(int)
    assert red > 2 * green
    assert green == blue


def test_materials_from_a_distribution_or_an_item(stage):
    materials, cubes = rep.create.material_omnipbr(count=2), rep.create.cube(count=2)
    for given in (rep.distribution.sequence(materials), materials):
        rep.randomizer.materials(given, input_prims=cubes, name="materials")
        evaluate.graph().evaluate()
        apis = [UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)) for path in cubes.prims]
        assert {str(api.ComputeBoundMaterial()[0].GetPath()) for api in apis} <= set(materials.prims)
    with pytest.raises(BadPrim, match="no prim /World/oak"):
        rep.randomizer.materials(["/World/oak"], input_prims=cubes)
