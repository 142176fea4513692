"""Search for prims, and their world transforms."""

import numpy as np
import pytest
from pxr import Gf, Usd

from usdsdg.errors import BadPrim, GraphError
from usdsdg.functional import create, create_batch, get, modify, utils


@pytest.fixture
def scene(stage):
    create_batch.cube(count=2, parent="/World", semantics={"class": "red_cube"})
    create.sphere(parent="/World", name="ball", as_mesh=False, semantics=[("class", "ball"), ("size", "big")])
    create.camera(parent="/World")
    create.sphere_light(parent="/World")
    create.material("OmniPBR.mdl", parent="/World/Looks")
    return stage


def paths(prims):
    return [str(prim.GetPath()) for prim in prims]


def test_paths_are_searched_with_regular_expressions_and_substrings(scene):
    assert paths(get.prims(scene, "Cube(_\\d+)?$")) == ["/World/Cube", "/World/Cube_01"]
    assert paths(get.prims(scene, "cube")) == []
    assert paths(get.prims(scene, "cube", ignore_case=True)) == ["/World/Cube", "/World/Cube_01"]
    assert paths(get.prims(path_match="Cube_")) == ["/World/Cube_01"]
    assert paths(get.prims(path_match="cube_", ignore_case=True)) == ["/World/Cube_01"]
    assert paths(get.prims(path_pattern="World/", path_pattern_exclusion="Cube|Looks|light|Light|ball")) == [
        "/World/Camera"
    ]
    with pytest.raises(GraphError, match="which is not a regular expression"):
        get.prims(path_pattern="(")


def test_types_are_case_insensitive(scene):
    assert paths(get.prims(prim_types="camera")) == ["/World/Camera"]
    assert paths(get.prims(prim_types=["Mesh", "SPHERE"])) == ["/World/Cube", "/World/Cube_01", "/World/ball"]
    assert paths(get.prims(path_match="/World/", prim_types_exclusion=["mesh", "shader", "material", "scope"])) == [
        "/World/ball", "/World/Camera", "/World/SphereLight",
    ]  # fmt: skip


def test_labels_match_substrings_and_any_label_suffices(scene):
    assert paths(get.prims(semantics=[("class", "cube")])) == ["/World/Cube", "/World/Cube_01"]
    assert paths(get.prims(semantics=("size", "big"))) == ["/World/ball"]
    assert paths(get.prims(semantics={"class": ["red", "ball"]})) == ["/World/Cube", "/World/Cube_01", "/World/ball"]
    assert paths(get.prims(prim_types=["mesh", "sphere"], semantics_exclusion=[("class", "cube")])) == ["/World/ball"]


@pytest.mark.parametrize(
    ("function", "type_name"),
    [
        ("camera", "Camera"), ("curve", "BasisCurves"), ("geomsubset", "GeomSubset"), ("graph", "OmniGraph"),
        ("light", "DomeLight"), ("listener", "OmniListener"), ("material", "Material"), ("mesh", "Mesh"),
        ("physics", "PhysicsScene"), ("renderproduct", "RenderProduct"), ("rendervar", "RenderVar"),
        ("scope", "Scope"), ("shader", "Shader"), ("shape", "Cube"), ("skelanimation", "SkelAnimation"),
        ("skeleton", "Skeleton"), ("sound", "OmniSound"), ("xform", "Xform"),
    ],
)  # fmt: skip
def test_functions_by_type(stage, function, type_name):
    stage.RemovePrim("/World")
    stage.DefinePrim("/there", type_name)
    stage.DefinePrim("/other", "Plane" if function == "mesh" else "Mesh")
    assert paths(getattr(get, function)(stage)) == ["/there"]
    assert paths(getattr(get, function)(path_match="there")) == ["/there"]
    assert getattr(get, function)(stage, "nowhere") == []


def test_another_stage(stage):
    other = Usd.Stage.CreateInMemory()
    other.DefinePrim("/lonely", "Cube")
    assert paths(get.shape(other)) == ["/lonely"]
    assert get.shape() == []


def test_prim_at_path(scene):
    assert get.prim_at_path(scene, "/World/Cube") == scene.GetPrimAtPath("/World/Cube")
    assert paths(get.prim_at_path(None, ["/World", "/World/Cube"])) == ["/World", "/World/Cube"]
    with pytest.raises(BadPrim, match="no prim /World/Kube"):
        get.prim_at_path(scene, "/World/Kube")
    assert paths(get.prim_at_paths(scene, "/World/Cube")) == ["/World/Cube"]
    assert paths(get.prim_at_paths(scene, ("/World", "/World/Cube"))) == ["/World", "/World/Cube"]


def test_inactive_prims_classes_and_what_is_inside_of_instances_are_not_found(scene):
    scene.GetPrimAtPath("/World/Cube").SetActive(False)
    scene.CreateClassPrim("/Kind")
    scene.DefinePrim("/Kind/Cube", "Cube")
    copy = scene.DefinePrim("/World/copy", "Xform")
    copy.GetReferences().AddInternalReference("/Kind")
    copy.SetInstanceable(True)
    assert paths(get.prims(path_pattern="Cube|Kind|copy")) == ["/World/Cube_01", "/World/copy"]


def test_labels_of_materials_are_those_of_the_shapes_that_show_them(scene):
    (rust,) = get.material(scene)
    modify.semantics(rust, {"state": "rusty"})
    modify.material(scene.GetPrimAtPath("/World"), rust)
    assert paths(get.prims(semantics=[("state", "rust")], prim_types=["Mesh", "Sphere", "Xform", "Material"])) == [
        "/World/Cube", "/World/Cube_01", "/World/ball", str(rust.GetPath()),
    ]  # fmt: skip


def test_world_transforms_of_prims(stage):
    parent = create.xform(position=(1, 2, 3), rotation=(0, 0, 90), scale=2)
    cube = create.cube(parent=parent, position=(1, 0, 0))
    assert Gf.IsClose(utils.get_world_position(cube), Gf.Vec3d(1, 4, 3), 1e-9)
    transform = utils.get_world_transform("/Xform/Cube")
    assert Gf.IsClose(transform.GetTranslation(), Gf.Vec3d(1, 4, 3), 1e-9)
    np.testing.assert_allclose(transform.GetScale(), (2, 2, 2))
    modify.position(parent, (0, 0, 0))
    assert Gf.IsClose(utils.get_world_position(cube), Gf.Vec3d(0, 2, 0), 1e-9)
