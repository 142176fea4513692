"""Attributes, labels, visibility, materials and variants that functional.modify writes."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

from usdsdg.errors import AssetNotFound, BadPrim, BadValue, GraphError, UsdsdgWarning
from usdsdg.functional import create, create_batch, modify
from usdsdg.stage.semantics.labels import get_labels


@pytest.fixture
def cubes(stage):
    return create_batch.cube(count=3, parent="/World", as_mesh=False)


def test_attribute_sets_one_value_or_one_per_prim(cubes):
    modify.attribute(cubes, "size", 3)
    assert [cube.GetAttribute("size").Get() for cube in cubes] == [3, 3, 3]
    modify.attribute(cubes, "size", np.array([1, 2, 3]))
    assert [cube.GetAttribute("size").Get() for cube in cubes] == [1, 2, 3]
    modify.attribute(cubes[0], "size", np.float32(0.5))
    assert cubes[0].GetAttribute("size").Get() == 0.5


@pytest.mark.parametrize(
    ("kind", "given", "held"),
    [
        ("float", 2, 2.0),
        ("int", 2.7, 2),
        ("bool", 1, True),
        ("token", "a", "a"),
        ("float3", (1, 2, 3), Gf.Vec3f(1, 2, 3)),
        ("color3f", [0.5, 0, 1], Gf.Vec3f(0.5, 0, 1)),
        ("double2", 3, Gf.Vec2d(3, 3)),
        ("quatf", (1, 0, 0, 0), Gf.Quatf(1)),
        ("color3f[]", [(1, 0, 0), (0, 1, 0)], [Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)]),
        ("color3f[]", (1, 0, 0), [Gf.Vec3f(1, 0, 0)]),
        ("float[]", [1, 2], [1.0, 2.0]),
        ("int[]", (1, 2), [1, 2]),
        ("token[]", ["a", "b"], ["a", "b"]),
    ],
)
def test_values_are_converted_to_the_type_of_the_attribute(stage, kind, given, held):
    prim = stage.DefinePrim("/World/thing")
    prim.CreateAttribute("it", Sdf.ValueTypeNames.Find(kind))
    modify.attribute(prim, "it", given)
    read = prim.GetAttribute("it").Get()
    assert (list(read) if kind.endswith("[]") else read) == held


def test_strings_for_assets_are_files(stage, tmp_path):
    light = create.dome_light()
    image = tmp_path / "sky.png"
    image.write_bytes(b"")
    modify.attribute(light, "texture:file", str(image))
    assert light.GetAttribute("inputs:texture:file").Get().path == str(image)
    with pytest.raises(AssetNotFound):
        modify.attribute(light, "inputs:texture:file", str(tmp_path / "none.png"))
    modify.attribute(light, "inputs:texture:file", "")
    assert light.GetAttribute("inputs:texture:file").Get().path == ""


@pytest.mark.parametrize(
    ("name", "value", "error", "says"),
    [
        ("sise", 1, BadPrim, "no attribute 'sise'; did you mean size"),
        ("size", "big", BadValue, "Cube.size is a double; it does not take 'big'"),
        ("size", (1, 2), BadValue, "does not take"),
        ("primvars:displayColor", "red", BadValue, "color3f"),
    ],
)
def test_invalid_attributes_and_values_raise_errors(cubes, name, value, error, says):
    with pytest.raises(error, match=says):
        modify.attribute(cubes[0], name, value)


def test_inputs_of_materials_are_set(stage, tmp_path):
    material = create.material("OmniPBR.mdl", diffuse_color_constant=(1, 0, 0))
    shader = UsdShade.Shader(material.GetChild("Shader"))
    modify.attribute(material, "metallic_constant", 0.5)
    modify.attribute([material], "inputs:diffuse_color_constant", [(0, 1, 0)])
    modify.attribute(shader.GetPrim(), "project_uvw", True)
    assert shader.GetInput("metallic_constant").Get() == 0.5
    assert shader.GetInput("diffuse_color_constant").Get() == Gf.Vec3f(0, 1, 0)
    assert shader.GetInput("project_uvw").Get() is True
    preview = UsdShade.Shader(material.GetChild("PreviewSurface"))
    assert preview.GetInput("diffuseColor").Get() == Gf.Vec3f(0, 1, 0)
    assert preview.GetInput("metallic").Get() == 0.5
    with pytest.raises(BadPrim, match="OmniPBR has no input 'metalic_constant'; did you mean metallic_constant"):
        modify.attribute(material, "metalic_constant", 0.5)
    with pytest.raises(AssetNotFound):
        modify.attribute(material, "diffuse_texture", str(tmp_path / "none.png"))


def test_semantics_are_added_replaced_and_cleared(cubes):
    modify.semantics(cubes, {"class": "a"})
    modify.semantics(cubes, [("class", "b"), ("kind", "c")])
    assert get_labels(cubes[2]) == {"class": ["a", "b"], "kind": ["c"]}
    modify.semantics(cubes[0], {"class": ["x", "y"]}, mode="replace")
    assert get_labels(cubes[0]) == {"class": ["x", "y"], "kind": ["c"]}
    modify.semantics(cubes[0], ("class", "z"), mode="CLEAR")
    assert get_labels(cubes[0]) == {"class": ["z"]}
    modify.semantics(cubes, [{"class": "1"}, [("class", "2")], {"class": ["3"]}], "clear")
    assert [get_labels(cube) for cube in cubes] == [{"class": ["1"]}, {"class": ["2"]}, {"class": ["3"]}]
    modify.semantics(cubes, mode="clear")
    assert [get_labels(cube) for cube in cubes] == [{}, {}, {}]


def test_invalid_semantics_raise_errors(cubes):
    with pytest.raises(GraphError, match="mode is 'swap'"):
        modify.semantics(cubes, {"class": "a"}, mode="swap")
    with pytest.raises(GraphError, match="semantics is 3"):
        modify.semantics(cubes, 3)


def test_visibility(cubes):
    modify.visibility(cubes, [True, False, True])
    shown = [UsdGeom.Imageable(cube).ComputeVisibility() for cube in cubes]
    assert shown == ["inherited", "invisible", "inherited"]
    modify.visibility(cubes[1], True)
    assert UsdGeom.Imageable(cubes[1]).ComputeVisibility() == "inherited"
    with pytest.raises(GraphError, match="visibility is 1"):
        modify.visibility(cubes, 1)


def test_prims_without_visibility_are_skipped_with_a_warning(stage, cubes):
    material = create.material("OmniPBR.mdl")
    with pytest.warns(UsdsdgWarning, match="/Material .* has no visibility"):
        modify.visibility([material, cubes[0]], False)
    assert UsdGeom.Imageable(cubes[0]).ComputeVisibility() == "invisible"


def test_material_binds_one_to_all_or_one_to_each(cubes):
    red, green = create_batch.material("OmniPBR.mdl", count=2)

    def bound():
        apis = [UsdShade.MaterialBindingAPI(cube).ComputeBoundMaterial()[0] for cube in cubes]
        return [api.GetPrim() for api in apis]

    modify.material(cubes, red)
    assert bound() == [red] * 3
    modify.material(cubes, [red, green, str(green.GetPath())])
    assert bound() == [red, green, green]
    with pytest.raises(BadPrim, match="/World/Cube is a Cube, not a Material"):
        modify.material(cubes, cubes[0])


def test_variant_selects(stage):
    shelf = stage.DefinePrim("/World/shelf", "Xform")
    colors = shelf.GetVariantSets().AddVariantSet("color")
    for name in ("red", "green"):
        colors.AddVariant(name)
    modify.variant(shelf, "color", "green")
    assert colors.GetVariantSelection() == "green"
    modify.variant([shelf], "color", ["red"])
    assert colors.GetVariantSelection() == "red"
    with pytest.raises(BadPrim, match="no variant set 'colour'; it has color"):
        modify.variant(shelf, "colour", "red")
    with pytest.raises(BadPrim, match="has no 'blue'; it has"):
        modify.variant(shelf, "color", "blue")


def test_one_value_in_a_list_labels_all_prims(stage):
    cubes = create_batch.cube(count=2)
    modify.semantics(cubes, [{"class": ["a", "b"]}])
    assert [get_labels(cube) for cube in cubes] == [{"class": ["a", "b"]}] * 2
    modify.semantics(cubes, ["class:c", "color:red"], mode="clear")
    assert [get_labels(cube) for cube in cubes] == [{"class": ["c"], "color": ["red"]}] * 2
