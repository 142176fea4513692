"""Materials created by create.material and create_batch.material."""

import pytest
from pxr import Gf, UsdShade

from usdsdg.errors import BadPrim, GraphError
from usdsdg.functional import create, create_batch


def inputs(material):
    shader = UsdShade.Shader(material.GetChild("Shader"))
    return {each.GetBaseName(): each.Get() for each in shader.GetInputs()}


def bound(prim):
    return UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPrim()


def test_a_material_is_an_mdl_shader_with_its_inputs(stage):
    material = create.material(
        "OmniPBR.mdl", diffuse_color_constant=(1, 0, 0), metallic_constant=0.25, enable_emission=True
    )
    assert str(material.GetPath()) == "/Material"
    shader, _, _ = UsdShade.Material(material).ComputeSurfaceSource("mdl")
    assert shader.GetSourceAsset("mdl").path == "OmniPBR.mdl"
    assert shader.GetSourceAssetSubIdentifier("mdl") == "OmniPBR"
    assert inputs(material) == {
        "diffuse_color_constant": Gf.Vec3f(1, 0, 0),
        "metallic_constant": 0.25,
        "enable_emission": True,
    }


def test_viewers_without_mdl_get_the_same_color(stage):
    material = create.material("OmniPBR.mdl", diffuse_color_constant=(1, 0, 0), reflection_roughness_constant=0.75)
    preview, _, _ = UsdShade.Material(material).ComputeSurfaceSource()
    assert preview.GetIdAttr().Get() == "UsdPreviewSurface"
    assert preview.GetInput("diffuseColor").Get() == Gf.Vec3f(1, 0, 0)
    assert preview.GetInput("roughness").Get() == 0.75


def test_the_renderer_reads_the_material(stage):
    from usdsdg_render.materials.mdl.material import mdl_name

    for mdl in ("OmniPBR.mdl", "/some/where/OmniGlass.mdl"):
        material = create.material(mdl)
        assert mdl_name(UsdShade.Shader(material.GetChild("Shader"))) in ("OmniPBR", "OmniGlass")


def test_a_material_is_bound_stronger_than_descendants(stage):
    group = create.xform()
    cube = create.cube(parent=group)
    create.material("OmniPBR.mdl", bind_prims=cube, name="weak")
    material = create.material("OmniPBR.mdl", bind_prims=group)
    assert bound(cube) == material
    spheres = create_batch.sphere(count=2)
    assert create.material("OmniPBR.mdl", bind_prims=spheres) == bound(spheres[0]) == bound(spheres[1])


def test_a_parent_that_does_not_exist_is_created_as_a_scope(stage):
    material = create.material("OmniPBR.mdl", parent="/World/Looks", name="red")
    assert str(material.GetPath()) == "/World/Looks/red"
    assert stage.GetPrimAtPath("/World/Looks").GetTypeName() == "Scope"
    with pytest.raises(BadPrim, match="'Looks' is not the path"):
        create.material("OmniPBR.mdl", parent="Looks")


def test_many_materials(stage):
    cubes = create_batch.cube(count=3)
    made = create_batch.material(
        "OmniPBR.mdl", cubes, count=3, diffuse_color_constant=[(1, 0, 0), (0, 1, 0), (0, 0, 1)], diffuse_tint=[1, 0, 1]
    )
    assert [str(each.GetPath()) for each in made] == ["/Material", "/Material_01", "/Material_02"]
    assert [bound(cube) for cube in cubes] == made
    assert inputs(made[1]) == {"diffuse_color_constant": Gf.Vec3f(0, 1, 0), "diffuse_tint": Gf.Vec3f(1, 0, 1)}


def test_other_mdl_modules_accept_any_input(stage):
    given = {"glass_color": (1, 1, 0), "glass_ior": 1.5, "thin_walled": True, "steps": 3}
    material = create.material("OmniGlass.mdl", **given)
    assert inputs(material) == given | {"glass_color": Gf.Vec3f(1, 1, 0)}


def test_invalid_materials_raise_errors(stage):
    cubes = create_batch.cube(count=3)
    with pytest.raises(GraphError, match="bind_prims has 3 entries for 2 materials"):
        create_batch.material("OmniPBR.mdl", cubes, count=2)
    with pytest.raises(BadPrim, match="OmniPBR has no input 'diffuse_colour'; did you mean"):
        create.material("OmniPBR.mdl", diffuse_colour=(1, 0, 0))
    with pytest.raises(BadPrim, match="no prim /Nothing"):
        create.material("OmniPBR.mdl", bind_prims="/Nothing")
