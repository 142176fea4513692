"""`rep.modify.attribute` on materials, their shaders and what `rep.get` finds of them."""

import numpy as np
import pytest
from pxr import Sdf, UsdShade

import usdsdg as rep
from usdsdg.graph import evaluate

RED = (1.0, 0.0, 0.0)


def value_of(stage, child, name):
    return stage.GetPrimAtPath(f"/Replicator/Looks/OmniPBR/{child}").GetAttribute(name).Get()


@pytest.mark.parametrize("name", ["diffuse_color_constant", "inputs:diffuse_color_constant"])
def test_an_attribute_of_a_material_is_an_input_of_its_shader(stage, name):
    with rep.create.material_omnipbr(diffuse=(0, 1, 0)):
        rep.modify.attribute(name, RED, attribute_type="color3f")
    evaluate.graph().evaluate()
    assert value_of(stage, "Shader", "inputs:diffuse_color_constant") == RED
    assert value_of(stage, "PreviewSurface", "inputs:diffuseColor") == RED
    material = stage.GetPrimAtPath("/Replicator/Looks/OmniPBR")
    assert not [each.GetName() for each in material.GetAttributes() if "diffuse" in each.GetName()]


def test_inputs_without_a_value_are_added_with_the_prefix(stage):
    with rep.create.material_omnipbr():
        rep.modify.attribute("reflection_roughness_constant", 0.25)
        rep.modify.attribute("own", 3.0, attribute_type="float")
    evaluate.graph().evaluate()
    assert value_of(stage, "Shader", "inputs:reflection_roughness_constant") == 0.25
    assert value_of(stage, "Shader", "inputs:own") == 3.0


def test_found_materials_and_shaders_take_distributions(stage):
    rep.create.material_omnipbr(diffuse=(0, 1, 0), count=3)
    with rep.get.material():
        rep.modify.attribute("metallic_constant", rep.distribution.uniform(0.5, 1.0))
    with rep.get.shader():
        rep.modify.attribute("inputs:diffuse_color_constant", rep.distribution.uniform(RED, RED))
    evaluate.graph().evaluate()
    assert value_of(stage, "Shader", "inputs:diffuse_color_constant") == RED
    assert value_of(stage, "PreviewSurface", "inputs:diffuseColor") == RED
    looks = stage.GetPrimAtPath("/Replicator/Looks").GetChildren()
    metallic = [each.GetChild("Shader").GetAttribute("inputs:metallic_constant").Get() for each in looks]
    assert len(set(metallic)) == 3
    assert min(metallic) >= 0.5


def test_the_helper_beside_an_mdl_shader_is_no_shader_that_is_found(stage):
    rep.create.material_omnipbr()
    own = UsdShade.Shader.Define(stage, "/World/Looks/PreviewSurface")
    own.CreateIdAttr("UsdPreviewSurface")
    expected = ["/World/Looks/PreviewSurface", "/Replicator/Looks/OmniPBR/Shader"]
    assert sorted(map(str, rep.get.shader().get_output("prims"))) == sorted(expected)
    assert sorted(str(prim.GetPath()) for prim in rep.functional.get.shader()) == sorted(expected)


def test_an_input_that_the_shader_takes_from_the_material_is_set_there(stage):
    material = UsdShade.Material.Define(stage, "/World/M")
    shader = UsdShade.Shader.Define(stage, "/World/M/S")
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    shared = material.CreateInput("roughness", Sdf.ValueTypeNames.Float)
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).ConnectToSource(shared)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    with rep.get.material():
        rep.modify.attribute("roughness", 0.5)
        rep.modify.attribute("diffuseColor", (0.25, 0.5, 0.75))
    evaluate.graph().evaluate()
    assert shared.Get() == 0.5
    assert shader.GetInput("diffuseColor").Get() == (0.25, 0.5, 0.75)


def test_pictures_show_the_change(stage):
    material = rep.create.material_omnipbr(diffuse=(0, 1, 0))
    rep.create.cube(material=material)
    with material:
        rep.modify.attribute("inputs:diffuse_color_constant", RED, attribute_type="color3f")
    albedo = rep.annotators.get("DiffuseAlbedo")
    albedo.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 0), look_at=(0, 0, 0)), (8, 8)))
    rep.orchestrator.step()
    assert np.array_equal(albedo.get_data()[4, 4, :3], [255, 0, 0])
