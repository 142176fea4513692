"""Labels that gprims inherit: from ancestors, through instances and instancers, from materials, at a time."""

import warnings

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSemantics, UsdShade

import usdsdg as rep
from usdsdg.annotators.ownership import LabeledStage
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.semantics.labels import add_labels, remove_labels


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


def labels_of(stage, gprim, time=None):
    """Return the labels that annotators report for a gprim, as plain lists."""
    labeled = LabeledStage(stage)
    if time is not None:
        labeled.set_time(Usd.TimeCode(time))
    ((_, chain),) = labeled.chains([gprim])
    if not chain:
        return {}
    return {kind: list(values) for kind, values in labeled.all_labels(chain[0][0], [gprim]).items()}


def owner_of(stage, gprim):
    ((_, chain),) = LabeledStage(stage).chains([gprim])
    return chain[0][0].name if chain else None


def cube(stage, path):
    return UsdGeom.Cube.Define(stage, path).GetPrim()


def bind(prim, material):
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def test_labels_are_listed_from_the_outermost_ancestor_to_the_prim(stage):
    for path, labels in {"/a": ["room"], "/a/b": ["shelf", "room"], "/a/b/c": ["box"]}.items():
        add_labels(stage.DefinePrim(path, "Xform"), {"class": labels})
    add_labels(stage.GetPrimAtPath("/a/b"), {"color": "red"})
    cube(stage, "/a/b/c/mesh")
    assert labels_of(stage, "/a/b/c/mesh") == {"class": ["room", "shelf", "box"], "color": ["red"]}
    assert labels_of(stage, str(cube(stage, "/x").GetPath())) == {}


def test_instances_inherit_from_where_they_are(stage):
    for path in ("/Class/box", "/Class/box/mesh"):
        stage.CreateClassPrim("/Class")
        stage.DefinePrim(path, "Cube" if path.endswith("mesh") else "Xform")
    add_labels(stage.GetPrimAtPath("/Class/box"), {"class": "box"})
    instance = stage.DefinePrim("/World/shelf/box", "Xform")
    instance.GetReferences().AddInternalReference("/Class/box")
    instance.SetInstanceable(True)
    add_labels(stage.GetPrimAtPath("/World/shelf"), {"class": "shelf"})
    assert labels_of(stage, "/World/shelf/box/mesh") == {"class": ["shelf", "box"]}


# --- point instancers ---


@pytest.mark.parametrize("home", ["/Shelf/Points/box", "/Lib/box", "/Shelf/box"])
def test_point_instances_inherit_from_their_instancer_wherever_the_prototype_is(stage, home):
    instancer = UsdGeom.PointInstancer.Define(stage, "/Shelf/Points")
    prototype = stage.DefinePrim(home, "Xform")
    cube(stage, f"{home}/mesh")
    instancer.CreatePrototypesRel().SetTargets([home])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0)])
    add_labels(prototype, {"class": "box"})
    add_labels(stage.GetPrimAtPath("/Shelf"), {"class": "shelf"})
    if home.startswith("/Lib"):
        add_labels(stage.GetPrimAtPath("/Lib"), {"class": "library"})
    assert labels_of(stage, f"{home}/mesh[1]") == {"class": ["shelf", "box"]}


@pytest.mark.parametrize("mode", ["scene_instance", "reference", "point_instance"])
@pytest.mark.parametrize("late", [False, True])
def test_each_instantiated_object_is_an_object_of_its_own(mode, late):
    stage = new_stage()
    cube(stage, "/Assets/box/mesh")
    semantics = [("class", "box")]
    item = rep.randomizer.instantiate(["/Assets/box"], size=4, mode=mode, semantics=None if late else semantics)
    if late:
        with item:
            rep.modify.semantics(semantics)
    names = gprims_below(stage, "/Replicator/SampledAssets")
    chains = [chain for _, chain in LabeledStage(stage).chains(names)]
    assert len(names) == 4
    assert len({chain[0][0].name for chain in chains}) == 4
    assert {labels_of(stage, name)["class"][0] for name in names} == {"box"}


def gprims_below(stage, root):
    """Return the gprims that a renderer would list, point instances with their numbers."""
    everything = Usd.PrimRange(stage.GetPrimAtPath(root), Usd.TraverseInstanceProxies())
    found = []
    for prim in everything:
        if prim.IsA(UsdGeom.Gprim):
            instancer = UsdGeom.PointInstancer(prim.GetParent().GetParent())
            count = len(instancer.GetProtoIndicesAttr().Get()) if instancer else 0
            found += [f"{prim.GetPath()}[{point}]" for point in range(count)] or [str(prim.GetPath())]
    return found


# --- materials ---


@pytest.fixture
def steel(stage):
    material = UsdShade.Material.Define(stage, "/Looks/steel")
    add_labels(material.GetPrim(), {"material": "steel", "class": "metal"})
    return material


def test_labels_of_a_material_count_for_the_prim_that_binds_it(stage, steel):
    mesh = cube(stage, "/World/car/body/mesh")
    bind(mesh, steel)
    assert labels_of(stage, "/World/car/body/mesh") == {"material": ["steel"], "class": ["metal"]}
    assert owner_of(stage, "/World/car/body/mesh") == "/World/car/body/mesh"


def test_labels_of_an_inherited_material_come_after_those_of_prims(stage, steel):
    mesh = cube(stage, "/World/cube")
    bind(stage.GetPrimAtPath("/World"), steel)
    add_labels(mesh, {"class": "cube"})
    assert labels_of(stage, "/World/cube") == {"class": ["cube", "metal"], "material": ["steel"]}
    assert owner_of(stage, "/World/cube") == "/World/cube"


def test_a_prim_whose_own_material_has_no_label_has_none_of_its_parents_material(stage, steel):
    mesh = cube(stage, "/World/cube")
    bind(stage.GetPrimAtPath("/World"), steel)
    bind(mesh, UsdShade.Material.Define(stage, "/Looks/plain"))
    assert labels_of(stage, "/World/cube") == {}


# --- time ---


def test_labels_that_are_time_samples_are_read_at_the_time(stage):
    mesh = cube(stage, "/World/light")
    attribute = UsdSemantics.LabelsAPI.Apply(mesh, "class").CreateLabelsAttr()
    attribute.Set(["red"], 0)
    attribute.Set(["green"], 10)
    assert labels_of(stage, "/World/light", 0) == {"class": ["red"]}
    assert labels_of(stage, "/World/light", 10) == {"class": ["green"]}
    labeled = LabeledStage(stage)
    assert not labeled.set_time(Usd.TimeCode(0))  # nothing read yet
    labeled.chains(["/World/light"])
    assert labeled.set_time(Usd.TimeCode(10))
    ((_, chain),) = labeled.chains(["/World/light"])
    assert chain[0][1] == {"class": ("green",)}


def test_a_schema_without_a_label_changes_nothing(stage):
    add_labels(stage.DefinePrim("/World/car", "Xform"), {"class": "car"})
    mesh = cube(stage, "/World/car/mesh")
    UsdSemantics.LabelsAPI.Apply(mesh, "class")
    assert owner_of(stage, "/World/car/mesh") == "/World/car"
    UsdSemantics.LabelsAPI(mesh, "class").CreateLabelsAttr().Set([])
    assert owner_of(stage, "/World/car/mesh") == "/World/car"
    UsdSemantics.LabelsAPI(mesh, "class").GetLabelsAttr().Set([" "])
    assert owner_of(stage, "/World/car/mesh") == "/World/car"
    assert Sdf.Path("/World/car").IsPrimPath()


def test_labels_whose_schema_is_not_applied_are_named_once(stage, recwarn):
    for path in ("/World/a", "/World/b"):
        prim = cube(stage, path)
        prim.CreateAttribute("semantics:labels:class", Sdf.ValueTypeNames.TokenArray).Set(["mug"])
        prim.CreateAttribute("semantic:Semantics:params:semanticData", Sdf.ValueTypeNames.String).Set("mug")
        assert labels_of(stage, path) == {}
    old, new = (str(each.message) for each in recwarn)
    assert old.startswith("/World/a: semantic:Semantics:params:semanticData is no label")
    assert new.startswith("/World/a: semantics:labels:class is no label")
    assert 'prepend apiSchemas = ["SemanticsLabelsAPI:class"]' in new


def test_labels_that_were_removed_from_an_asset_are_not_named(stage, recwarn):
    stage.CreateClassPrim("/Asset")
    add_labels(cube(stage, "/Asset/mug"), {"class": "mug"})
    stage.DefinePrim("/World/asset").GetReferences().AddInternalReference("/Asset")
    remove_labels(stage.GetPrimAtPath("/World/asset"), recursive=True)
    assert labels_of(stage, "/World/asset/mug") == {}
    assert not recwarn.list


@pytest.mark.parametrize("schema", ["SemanticsLabelsAPI:class", "SemanticsAPI:Semantics_class"])
def test_a_schema_without_a_label_is_told_and_one_that_is_emptied_is_not(stage, schema):
    prim = cube(stage, "/a")
    prim.ApplyAPI(*schema.split(":"))
    with pytest.warns(UsdsdgWarning, match=f"/a has {schema} and no label in it"):
        assert labels_of(stage, "/a") == {}
    forget_warnings()
    name = "semantics:labels:class" if "Labels" in schema else "semantic:Semantics_class:params:semanticData"
    for value in ([] if "Labels" in schema else "", Sdf.ValueBlock()):
        prim.GetAttribute(name).Set(value)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert labels_of(stage, "/a") == {}
    prim.GetAttribute(name).Clear()
    add_labels(prim, {"class": "box"})
    remove_labels(prim)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert labels_of(stage, "/a") == {}
