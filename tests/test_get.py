"""`rep.get`: search for prims by path, type and labels."""

import pytest

import usdsdg as rep
from usdsdg import get
from usdsdg.errors import ArgumentError, BadPrim, GraphError
from usdsdg.graph import evaluate
from usdsdg.session import stage_context
from usdsdg.stage.semantics import labels


@pytest.fixture
def stage(stage):
    rep.create.cube(count=2, semantics=[("class", "crate")])
    rep.create.sphere(semantics=[("class", "ball"), ("color", "red")], as_mesh=False)
    rep.create.light(light_type="Dome")
    rep.create.camera()
    return stage


def test_paths_match_patterns_and_substrings(stage):
    assert get.prims(path_pattern=r"cube_xform(_\d+)?$").prims == (
        "/Replicator/Cube_Xform",
        "/Replicator/Cube_Xform_01",
    )
    assert get.prims(path_match="cube_", path_pattern_exclusion="_01").prims == (
        "/Replicator/Cube_Xform",
        "/Replicator/Cube_Xform/Cube",
    )
    assert get.prims(path_match="cube_", ignore_case=False).prims == ()


def test_types_and_labels(stage):
    assert get.prims(prim_types=["mesh", "SPHERE"]).prims == (
        "/Replicator/Cube_Xform/Cube",
        "/Replicator/Cube_Xform_01/Cube",
        "/Replicator/Sphere_Xform/Sphere",
    )
    assert get.prims(semantics=[("class", "ball")]).prims == ("/Replicator/Sphere_Xform",)
    labeled = get.prims(semantics=[("class", "crate"), ("class", "ball")], semantics_exclusion=("color", "red"))
    assert labeled.prims == ("/Replicator/Cube_Xform", "/Replicator/Cube_Xform_01")


@pytest.mark.parametrize(
    ("kind", "found"),
    [
        ("mesh", ["/Replicator/Cube_Xform/Cube", "/Replicator/Cube_Xform_01/Cube"]),
        ("shape", ["/Replicator/Sphere_Xform/Sphere"]),
        ("light", ["/Replicator/DomeLight_Xform/DomeLight"]),
        ("camera", ["/Replicator/Camera_Xform/Camera"]),
        ("scope", ["/Replicator"]),
        ("skeleton", []),
    ],
)
def test_each_type_has_a_function(stage, kind, found):
    assert list(getattr(get, kind)().prims) == found
    assert getattr(get, kind)(path_pattern="nowhere").prims == ()


@pytest.mark.parametrize(
    ("function", "type_name"),
    [
        ("camera", "Camera"), ("curve", "BasisCurves"), ("geomsubset", "GeomSubset"), ("light", "DomeLight"),
        ("listener", "OmniListener"), ("material", "Material"), ("mesh", "Mesh"), ("physics", "PhysicsScene"),
        ("renderproduct", "RenderProduct"), ("rendervar", "RenderVar"), ("scope", "Scope"), ("shader", "Shader"),
        ("shape", "Cube"), ("skelanimation", "SkelAnimation"), ("skeleton", "Skeleton"), ("sound", "OmniSound"),
        ("xform", "Xform"),
    ],
)  # fmt: skip
def test_functions_by_type_accept_the_other_conditions(function, type_name):
    stage, find = stage_context.new_stage(), getattr(get, function)
    for name, label in (("one", "red"), ("two", "blue")):
        labels.add_labels(stage.DefinePrim(f"/There/{name}", type_name), {"color": [label]})
    stage.DefinePrim("/There/other", "Mesh" if function == "xform" else "Xform")
    assert find(path_match="there/").prims == ("/There/one", "/There/two")
    assert find(path_pattern="(one|two)$", path_pattern_exclusion="two").prims == ("/There/one",)
    assert find(semantics=[("color", "blue")]).prims == ("/There/two",)
    assert find(path_match="there/", semantics_exclusion={"color": "blue"}, name="mine").prims == ("/There/one",)
    assert find(name="mine").node.name == "mine"


def test_found_prims_can_be_modified(stage):
    with get.mesh(path_match="01"):
        rep.modify.pose(position=(1, 2, 3))
    evaluate.graph().evaluate()
    child = stage.GetPrimAtPath("/Replicator/Cube_Xform_01/Cube")
    assert child.GetAttribute("xformOp:translate").Get() == (1, 2, 3)
    # The graph is on the stage, but its nodes are not results of a search.
    assert get.prims(path_match="Ogn").prims == ()
    assert get.graph().prims == ("/Replicator/SDGPipeline",)


def test_prims_at_paths(stage):
    both = get.prim_at_path(["/Replicator/Cube_Xform", stage.GetPrimAtPath("/World")])
    assert both.prims == ("/Replicator/Cube_Xform", "/World")
    with pytest.raises(BadPrim, match="/World/nowhere"):
        get.prim_at_path("/World/nowhere")


def test_invalid_patterns_raise_errors(stage):
    with pytest.raises(GraphError, match="not a regular expression"):
        get.prims(path_pattern="(")


@pytest.mark.parametrize("name", ["path_pattern", "path_match", "path_pattern_exclusion"])
def test_lists_of_paths_are_errors_that_say_what_to_give(stage, name):
    with pytest.raises(ArgumentError, match=rf"{name} is \['a', 'b'\]; expected one text; .*a\|b"):
        rep.get.prims(**{name: ["a", "b"]})


def test_a_path_with_a_wildcard_is_an_error_with_the_pattern_that_finds_the_prims(stage):
    names = [str(stage.DefinePrim(f"/World/objects/{name}", "Cube").GetPath()) for name in "ab"]
    stage.DefinePrim("/World/objects/a/inner", "Cube")
    with pytest.raises(BadPrim, match=r"is not the path of one prim") as caught:
        rep.get.prim_at_path("/World/objects/*")
    pattern = str(caught.value).partition("path_pattern='")[2].partition("'")[0]
    assert list(rep.get.prims(path_pattern=pattern).prims) == names


def test_functions_of_scripts_can_be_registered_in_get(stage):
    def crates():
        return get.prims(semantics=[("class", "crate")])

    get.register(crates)
    assert len(get.crates().prims) == 2
    with pytest.raises(ValueError, match="'crates' exists"):
        get.register(crates, override=False)
    del get.crates


def test_a_distribution_of_what_is_no_prim_is_an_error(stage):
    with pytest.raises(BadPrim, match=r"does not draw from prims that are on the stage.*randomizer\.instantiate"):
        get.prim_at_path(rep.distribution.choice(["/Replicator/Nowhere"]))
