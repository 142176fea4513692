"""Visibility, variants, materials, attributes and labels that `rep.modify` writes."""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg.errors import ArgumentError, BadPrim, GraphError, UsdsdgWarning
from usdsdg.graph import evaluate
from usdsdg.stage.semantics import labels


def fire():
    rep.utils.send_og_event("go")
    evaluate.graph().evaluate()


def visibility_of(stage, item):
    return [UsdGeom.Imageable(stage.GetPrimAtPath(path)).ComputeVisibility() == "inherited" for path in item.prims]


def bound(stage, item):
    apis = [UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(path)) for path in item.prims]
    return [str(api.ComputeBoundMaterial()[0].GetPath()) for api in apis]


# --- visibility ---


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (True, [True, True]),
        (False, [False, False]),
        ([True, False], [True, False]),
        ([1, 0], [True, False]),
        ((False, True), [False, True]),
    ],
)
def test_prims_are_shown_and_hidden_immediately(stage, value, expected):
    cubes = rep.create.cube(count=2)
    rep.modify.visibility(list(value) if isinstance(value, tuple) else value, input_prims=cubes)
    assert visibility_of(stage, cubes) == expected


def test_without_a_value_visibility_is_sampled_for_each_prim_at_each_firing(stage):
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=40) as cubes:
        rep.modify.visibility()
    seen = []
    for _ in range(2):
        fire()
        seen.append(visibility_of(stage, cubes))
        # Binomial with n = 40, p = 1/2: five standard deviations are 16.
        assert abs(sum(seen[-1]) - 20) < 16
    assert seen[0] != seen[1]


@pytest.mark.parametrize("value", ["no", 2, [True, "no"]])
def test_invalid_visibility_raises_an_error(stage, value):
    with pytest.raises(GraphError, match=r"visibility is .*; expected True, False, or a list"):
        rep.modify.visibility(value, input_prims=rep.create.cube(count=2))


@pytest.mark.parametrize("stride", [None, 1, 3])
def test_a_sequence_of_patterns_over_a_group_shows_one_at_each_firing(stage, stride):
    with rep.trigger.on_custom_event("go"), rep.create.group([rep.create.cube(), rep.create.sphere()]) as group:
        rep.modify.visibility(rep.distribution.sequence([[True, False], [False, True]], stride=stride))
    seen = []
    for _ in range(3):
        fire()
        seen.append(visibility_of(stage, group))
    assert seen == [[True, False], [False, True], [True, False]]


def test_a_sequence_shows_or_hides_all_prims_of_a_group(stage):
    with rep.trigger.on_custom_event("go"), rep.create.group([rep.create.cube(), rep.create.sphere()]) as group:
        rep.modify.visibility(rep.distribution.sequence([True, False]))
    seen = []
    for _ in range(3):
        fire()
        seen.append(visibility_of(stage, group))
    assert seen == [[True, True], [False, False], [True, True]]


def test_a_sequence_along_one_axis_moves_all_prims_of_a_group(stage):
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=3, position=(0, 7, 0)) as cubes:
        rep.modify.pose(position_x=rep.distribution.sequence([10, 20]), rotation_z=rep.distribution.uniform(0, 90))
    for x in (10, 20, 10):
        fire()
        prims = [stage.GetPrimAtPath(path) for path in cubes.prims]
        assert [prim.GetAttribute("xformOp:translate").Get() for prim in prims] == [(x, 7, 0)] * 3
        assert len({prim.GetAttribute("xformOp:rotateXYZ").Get()[2] for prim in prims}) == 3


def test_a_choice_of_patterns_is_one_for_the_group(stage):
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=3) as cubes:
        rep.modify.visibility(rep.distribution.choice([[True, False, False], [False, True, True]]))
    seen = set()
    for _ in range(20):
        fire()
        seen.add(tuple(visibility_of(stage, cubes)))
    assert seen == {(True, False, False), (False, True, True)}


# --- variants ---


@pytest.fixture
def shelves(stage):
    """Two prims with the variants red, green and blue of "color"."""
    for name in "ab":
        colors = stage.DefinePrim(f"/World/{name}", "Xform").GetVariantSets().AddVariantSet("color")
        for color in ("red", "green", "blue"):
            colors.AddVariant(color)
    return rep.create.group(["/World/a", "/World/b"])


def selected(stage, item):
    return [stage.GetPrimAtPath(path).GetVariantSets().GetVariantSelection("color") for path in item.prims]


def test_the_variant_of_what_from_usd_made_is_that_of_the_asset(stage, tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "shape.usda"))
    root = UsdGeom.Xform.Define(asset, "/Shape").GetPrim()
    asset.SetDefaultPrim(root)
    variants = root.GetVariantSets().AddVariantSet("shape")
    for name in ("Cube", "Sphere"):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            asset.DefinePrim("/Shape/thing", name)
    variants.SetVariantSelection("Cube")
    asset.Save()
    made = rep.create.from_usd(str(tmp_path / "shape.usda"))
    rep.modify.variant("shape", "Sphere", input_prims=made)
    fire()
    below = Usd.PrimRange(stage.GetPrimAtPath(made.prims[0]))
    assert [prim.GetTypeName() for prim in below if prim.GetName() == "thing"] == ["Sphere"]
    rep.modify.variant("color", "red", input_prims=made)
    with pytest.raises(GraphError, match="no variant set 'color'"):
        fire()


def test_a_variant_may_be_one_for_all_or_drawn(stage, shelves):
    for value, expected in (("green", ["green", "green"]), (["blue"], ["blue", "blue"])):
        rep.modify.variant("color", value, input_prims=shelves)
        evaluate.graph().evaluate()
        assert selected(stage, shelves) == expected
    with rep.trigger.on_custom_event("go"), shelves:
        rep.modify.variant("color", rep.distribution.sequence(["green", "blue", "red"]))
    fire()
    assert selected(stage, shelves) == ["green", "green"]
    fire()
    assert selected(stage, shelves) == ["blue", "blue"]


def test_of_a_list_of_variants_one_is_drawn_for_each_prim_at_each_firing(stage, shelves):
    with rep.trigger.on_custom_event("go"), shelves:
        rep.modify.variant("color", ["red", "green", "blue"])
    seen = set()
    for _ in range(12):
        fire()
        seen.add(tuple(selected(stage, shelves)))
    assert {color for pair in seen for color in pair} == {"red", "green", "blue"}
    assert len(seen) > 3


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [("colour", "red", "no variant set 'colour'; it has color"), ("color", "rad", "has no 'rad'; it has .*red")],
)
def test_unknown_variants_raise_an_error_with_the_script_line(stage, shelves, name, value, message):
    rep.modify.variant(name, value, input_prims=shelves)
    with pytest.raises(GraphError, match=rf"test_modify\.py:\d+\): /World/a.*{message}"):
        evaluate.graph().evaluate()


# --- materials ---


def test_materials_are_bound_immediately_and_those_of_prims_below_win(stage):
    cubes, looks = rep.create.cube(count=2), rep.create.material_omnipbr(count=2)
    other = UsdShade.Material.Define(stage, "/World/other")
    rep.modify.material(looks.prims[1], input_prims=cubes)
    assert bound(stage, cubes) == [looks.prims[1]] * 2
    rep.modify.material(looks, input_prims=cubes)
    assert bound(stage, cubes) == list(looks.prims)
    rep.modify.material(other.GetPrim(), input_prims=cubes)
    assert bound(stage, cubes) == ["/World/other"] * 2

    child = stage.GetPrimAtPath(f"{cubes.prims[0]}/Cube")
    UsdShade.MaterialBindingAPI.Apply(child).Bind(other)
    with pytest.warns(
        UsdsdgWarning, match=f"{cubes.prims[0]}: the material .* no effect.* {child.GetPath()},"
    ) as caught:
        rep.modify.material(looks.prims[1], input_prims=cubes)
    assert len(caught) == 1
    assert str(UsdShade.MaterialBindingAPI(child).ComputeBoundMaterial()[0].GetPath()) == "/World/other"


@pytest.mark.filterwarnings("error")
def test_each_mesh_that_a_search_by_path_finds_shows_its_own_material(stage):
    """Scripts that randomize parts of an asset find its meshes together with the Xforms above these."""
    looks = rep.create.material_omnipbr(count=5)
    UsdGeom.Xform.Define(stage, "/World/truck")
    for index in range(20):
        UsdGeom.Cube.Define(stage, f"/World/truck/part{index}")
    with rep.get.prims(path_pattern="truck"):
        rep.randomizer.materials(looks)
    evaluate.graph().evaluate()
    parts = [UsdShade.MaterialBindingAPI(each) for each in stage.GetPrimAtPath("/World/truck").GetChildren()]
    assert len({str(part.ComputeBoundMaterial()[0].GetPath()) for part in parts}) > 2


def test_of_a_list_of_materials_one_is_drawn_for_each_prim_at_each_firing(stage):
    first, second = rep.create.material_omnipbr(count=2), rep.create.material_omnipbr()
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=3) as cubes:
        rep.modify.material([first, second.prims[0]])
    seen = set()
    for _ in range(8):
        fire()
        seen.add(tuple(bound(stage, cubes)))
    assert {path for each in seen for path in each} == {*first.prims, *second.prims}
    assert len(seen) > 3
    several = rep.create.cube(count=2, material=list(first.prims))
    assert bound(stage, several) == list(first.prims)


def test_materials_are_sampled_at_each_firing(stage):
    looks = rep.create.material_omnipbr(count=3)
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=2) as cubes:
        rep.modify.material(rep.distribution.sequence(looks))
    fire()
    assert bound(stage, cubes) == [looks.prims[0]] * 2
    fire()
    assert bound(stage, cubes) == [looks.prims[1]] * 2


@pytest.mark.parametrize("value", [None, [], ()])
def test_binding_no_material_raises_an_error(stage, value):
    with pytest.raises(ArgumentError, match=r"modify\.material: value is .*; give at least one material"):
        rep.modify.material(value, input_prims=rep.create.cube())


def test_an_attribute_whose_name_is_no_text_raises_an_error(stage):
    with pytest.raises(ArgumentError, match=r"modify\.attribute: name is 3; expected text"):
        rep.modify.attribute(3, "focalLength", input_prims=rep.create.camera())


def test_binding_a_prim_that_is_not_a_material_raises_an_error(stage):
    cube = rep.create.cube()
    with pytest.raises(BadPrim, match="/World is a Xform, not a Material"):
        rep.modify.material("/World", input_prims=cube)
    with pytest.raises(BadPrim, match="no prim /World/Oak"):
        rep.create.cube(material="/World/Oak")


# --- attributes ---


def test_attributes_are_set_on_the_child_of_an_object_and_on_inputs(stage):
    lights = rep.create.light(light_type="Sphere", count=2)
    rep.modify.attribute("radius", [0.5, 2.0], input_prims=lights)
    rep.modify.attribute("inputs:color", (1, 0.5, 0.25), input_prims=lights)
    evaluate.graph().evaluate()
    children = [stage.GetPrimAtPath(f"{path}/SphereLight") for path in lights.prims]
    assert [child.GetAttribute("inputs:radius").Get() for child in children] == [0.5, 2.0]
    assert [child.GetAttribute("inputs:color").Get() for child in children] == [(1, 0.5, 0.25)] * 2


def test_a_list_of_numbers_is_one_array_or_vector_even_for_as_many_prims(stage):
    paths = [str(stage.DefinePrim(f"/World/c{i}", "BasisCurves").GetPath()) for i in range(3)]
    rep.modify.attribute("widths", [1.0, 2.0, 3.0], input_prims=paths)
    rep.modify.attribute("tint", [0.5, 0.25, 1.0], attribute_type="color3f", input_prims=paths)
    rep.modify.attribute("heat", [1, 2, 3], attribute_type="float", input_prims=paths)
    evaluate.graph().evaluate()
    prims = [stage.GetPrimAtPath(path) for path in paths]
    assert [list(prim.GetAttribute("widths").Get()) for prim in prims] == [[1, 2, 3]] * 3
    assert [prim.GetAttribute("tint").Get() for prim in prims] == [(0.5, 0.25, 1)] * 3
    assert [prim.GetAttribute("heat").Get() for prim in prims] == [1, 2, 3]


@pytest.mark.parametrize(
    ("type_name", "value", "held"),
    [
        ("float", 2, 2.0),
        ("int", 2.9, 2),
        ("bool", 1, True),
        ("token", "a", "a"),
        ("double3", 3, (3, 3, 3)),
        ("color3f", (0.5, 0.25, 1), (0.5, 0.25, 1)),
    ],
)
def test_an_attribute_is_created_if_its_type_is_given(stage, type_name, value, held):
    cube = rep.create.cube()
    rep.modify.attribute("made", value, attribute_type=type_name, input_prims=cube)
    evaluate.graph().evaluate()
    made = stage.GetPrimAtPath(f"{cube.prims[0]}/Cube").GetAttribute("made")
    assert made.Get() == held
    assert made.GetTypeName() == Sdf.ValueTypeNames.Find(type_name)


def test_attributes_of_a_lens_need_no_type(stage):
    own = UsdGeom.Camera.Define(stage, "/World/Camera")
    cameras = rep.create.group([rep.create.camera(), "/World/Camera"])
    with cameras:
        rep.modify.attribute("cameraProjectionType", "fisheyeOpenCV")
        rep.modify.attribute("fthetaWidth", 64)
        rep.modify.attribute("openCVFx", rep.distribution.uniform(40.0, 41.0))
    evaluate.graph().evaluate()
    for prim in (stage.GetPrimAtPath("/Replicator/Camera_Xform/Camera"), own.GetPrim()):
        assert prim.GetAttribute("cameraProjectionType").Get() == "fisheyeOpenCV"
        assert prim.GetAttribute("fthetaWidth").Get() == 64
        assert 40 <= prim.GetAttribute("openCVFx").Get() <= 41
        assert str(prim.GetAttribute("openCVFx").GetTypeName()) == "float"

    with rep.create.cube():
        rep.modify.attribute("openCVFx", 40.0)
    with pytest.raises(GraphError, match="no attribute 'openCVFx'"):
        evaluate.graph().evaluate()


def test_errors_for_misspelled_attributes_and_types_list_near_misses(stage):
    cube = rep.create.cube(as_mesh=False)
    for arguments, message in (
        (("sise", 1), "has no attribute 'sise'; similar: size.*Pass attribute_type"),
        (("made", 1, "flaot"), "attribute_type='flaot' is not a USD value type; did you mean float"),
        (("size", "big"), "is a double; it does not take 'big'"),
    ):
        rep.modify.attribute(*arguments, input_prims=cube)
        with pytest.raises(GraphError, match=rf"test_modify\.py:\d+\).*{message}"):
            evaluate.graph().evaluate()


def test_colors_of_prims_are_written_and_sampled(stage):
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=20) as cubes:
        rep.modify.attribute("primvars:displayColor", rep.distribution.uniform((0, 0, 0.5), (1, 0, 1)))
    fire()
    drawn = [stage.GetPrimAtPath(f"{path}/Cube").GetAttribute("primvars:displayColor").Get() for path in cubes.prims]
    assert len({tuple(colors[0]) for colors in drawn}) == 20
    assert all(len(colors) == 1 and colors[0][1] == 0 and colors[0][2] >= 0.5 for colors in drawn)


def test_strings_for_assets_are_files_below_the_assets_root(stage, tmp_path):
    (tmp_path / "night.hdr").write_bytes(b"")
    dome = rep.create.light(light_type="dome")
    rep.modify.attribute("texture:file", str(tmp_path / "night.hdr"), input_prims=dome)
    evaluate.graph().evaluate()
    file = stage.GetPrimAtPath(f"{dome.prims[0]}/DomeLight").GetAttribute("inputs:texture:file").Get()
    assert file.path == str(tmp_path / "night.hdr")
    rep.modify.attribute("texture:file", rep.distribution.choice([str(tmp_path / "nigt.hdr")]), input_prims=dome)
    with pytest.raises(GraphError, match=r"test_modify\.py:\d+.*did you mean night\.hdr"):
        evaluate.graph().evaluate()


# --- labels ---


def test_labels_are_added_replaced_and_cleared_immediately(stage):
    cube = rep.create.cube(semantics=[("class", "a")])
    prim = stage.GetPrimAtPath(cube.prims[0])
    for given, mode, expected in (
        ([("class", "b"), ("part", "p")], "add", {"class": ["a", "b"], "part": ["p"]}),
        ({"class": "c"}, "replace", {"class": ["c"], "part": ["p"]}),
        ({"class": ["d"]}, "clear", {"class": ["d"]}),
        (None, "clear", {}),
    ):
        rep.modify.semantics(given, input_prims=cube, mode=mode)
        assert labels.get_labels(prim) == expected
    with pytest.raises(GraphError, match="mode='ad'; known: add, replace, clear"):
        rep.modify.semantics([("class", "a")], input_prims=cube, mode="ad")


def test_labels_inside_a_trigger_are_written_when_it_fires(stage):
    with rep.trigger.on_custom_event("go"), rep.create.cube(count=2) as cubes:
        rep.modify.semantics([{"class": "x"}, {"class": "y"}])
    prims = [stage.GetPrimAtPath(path) for path in cubes.prims]
    assert [labels.get_labels(prim) for prim in prims] == [{}, {}]
    fire()
    assert [labels.get_labels(prim) for prim in prims] == [{"class": ["x"]}, {"class": ["y"]}]
