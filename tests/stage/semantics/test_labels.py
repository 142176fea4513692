import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSemantics

from usdsdg.errors import BadPrim, UsdsdgWarning, forget_warnings
from usdsdg.stage.schemas.semantics_schema import SemanticsAPI
from usdsdg.stage.semantics import labels as semantics


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


@pytest.fixture
def prim(stage):
    return stage.DefinePrim("/World/mug", "Xform")


def old_pairs(prim):
    return {(api.GetSemanticTypeAttr().Get(), api.GetSemanticDataAttr().Get()) for api in SemanticsAPI.GetAll(prim)}


@pytest.fixture
def asset(tmp_path):
    """A referenced asset with labels in both schemas, on its root and below."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    root = stage.DefinePrim("/Asset", "Xform")
    stage.SetDefaultPrim(root)
    api = SemanticsAPI.Apply(root, "Semantics")
    api.CreateSemanticTypeAttr().Set("class")
    api.CreateSemanticDataAttr().Set("old_mug")
    handle = stage.DefinePrim("/Asset/handle", "Cube")
    UsdSemantics.LabelsAPI.Apply(handle, "class").CreateLabelsAttr().Set(["handle"])
    stage.Save()
    return str(tmp_path / "asset.usda")


def test_labels_are_authored_in_both_schemas(prim):
    semantics.add_labels(prim, {"class": ["mug", "cup"], "color": "red"})
    assert prim.GetAppliedSchemas()[0] == "SemanticsLabelsAPI:class"
    assert list(UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Get()) == ["mug", "cup"]
    assert old_pairs(prim) == {("class", "mug"), ("class", "cup"), ("color", "red")}
    assert semantics.get_labels(prim) == {"class": ["mug", "cup"], "color": ["red"]}


def test_usd_semantics_reads_what_we_write(stage, prim):
    semantics.add_labels(prim, [("class", "mug")])
    child = stage.DefinePrim("/World/mug/handle", "Cube")
    query = UsdSemantics.LabelsQuery("class", Usd.TimeCode.Default())
    assert query.ComputeUniqueInheritedLabels(child) == ["mug"]


def test_either_schema_alone_is_read(stage):
    new, old = stage.DefinePrim("/new"), stage.DefinePrim("/old")
    UsdSemantics.LabelsAPI.Apply(new, "class").CreateLabelsAttr().Set(["a", "b"])
    api = SemanticsAPI.Apply(old, "Semantics_x")
    assert semantics.get_labels(old) == {}
    api.CreateSemanticTypeAttr().Set("class")
    api.CreateSemanticDataAttr().Set("c")
    assert semantics.get_labels(new) == {"class": ["a", "b"]}
    assert semantics.get_labels(old) == {"class": ["c"]}


def test_the_old_schema_as_written_by_other_programs_is_read(stage):
    """Isaac assets carry only the applied schema names and attributes that any text editor could write."""
    stage.GetRootLayer().ImportFromString(
        """#usda 1.0
        def Xform "a" (prepend apiSchemas = ["SemanticsAPI:Semantics_Yx9k", "SemanticsAPI:Semantics_2"]) {
            string semantic:Semantics_Yx9k:params:semanticData = "crate"
            string semantic:Semantics_Yx9k:params:semanticType = "class"
            string semantic:Semantics_2:params:semanticData = "box"
            string semantic:Semantics_2:params:semanticType = "class"
        }"""
    )
    assert semantics.get_labels(stage.GetPrimAtPath("/a")) == {"class": ["crate", "box"]}


def test_add_keeps_replace_replaces_the_type_and_clear_replaces_all(prim):
    semantics.add_labels(prim, {"class": ["a"], "color": ["red"]})
    semantics.add_labels(prim, {"class": ["b", "a"]})
    assert semantics.get_labels(prim) == {"class": ["a", "b"], "color": ["red"]}
    semantics.add_labels(prim, {"class": ["c"]}, mode="replace")
    assert semantics.get_labels(prim) == {"class": ["c"], "color": ["red"]}
    assert old_pairs(prim) == {("class", "c"), ("color", "red")}
    semantics.add_labels(prim, {"shape": ["round"]}, mode="clear")
    assert semantics.get_labels(prim) == {"shape": ["round"]}
    semantics.add_labels(prim, {}, mode="clear")
    assert semantics.get_labels(prim) == {}


def test_replacing_a_type_by_nothing_removes_it(prim):
    semantics.add_labels(prim, {"class": ["a"], "color": ["red"]})
    semantics.add_labels(prim, {"class": []}, mode="replace")
    assert semantics.get_labels(prim) == {"color": ["red"]}
    assert "SemanticsLabelsAPI:class" not in prim.GetAppliedSchemas()


def test_a_removed_label_can_be_added_again(prim):
    semantics.add_labels(prim, {"class": ["a"]})
    semantics.remove_labels(prim)
    semantics.add_labels(prim, {"class": ["a"]})
    assert semantics.get_labels(prim) == {"class": ["a"]}
    assert old_pairs(prim) == {("class", "a")}


def test_labels_with_any_characters(prim):
    labels = ["003 cracker-box", "a b", "a_b", "größe"]
    semantics.add_labels(prim, {"class": labels, "my type!": ["x"]})
    assert semantics.get_labels(prim) == {"class": labels, "my type!": ["x"]}
    semantics.remove_labels(prim)
    assert semantics.get_labels(prim) == {}


@pytest.mark.parametrize("labels", [{"class": [""]}, {"": ["a"]}, {"class": [3]}, [("class", None)]])
def test_labels_are_strings(prim, labels):
    with pytest.raises((ValueError, TypeError)):
        semantics.add_labels(prim, labels)


def test_an_unknown_mode_is_refused(prim):
    with pytest.raises(ValueError, match="'merge'"):
        semantics.add_labels(prim, {"class": "a"}, mode="merge")


def test_isaacs_helper_overwrites_the_type(prim):
    semantics.add_update_semantics(prim, "mug")
    semantics.add_update_semantics(prim, "cup")
    semantics.add_update_semantics(prim, "red", "color")
    assert semantics.get_labels(prim) == {"class": ["cup"], "color": ["red"]}


def test_isaacs_helper_with_suffixes_holds_several_labels(prim):
    semantics.add_update_semantics(prim, "mug")
    semantics.add_update_semantics(prim, "vessel", suffix="_2")
    assert semantics.get_labels(prim) == {"class": ["mug", "vessel"]}
    assert ("class", "vessel") in old_pairs(prim)
    semantics.add_update_semantics(prim, "bowl", suffix="_2")
    assert semantics.get_labels(prim) == {"class": ["mug", "bowl"]}
    assert old_pairs(prim) == {("class", "mug"), ("class", "bowl")}


def test_referenced_labels_are_read_overwritten_and_removed(stage, prim, asset):
    prim.GetReferences().AddReference(asset)
    handle = stage.GetPrimAtPath("/World/mug/handle")
    assert semantics.get_labels(prim) == {"class": ["old_mug"]}
    assert semantics.get_labels(handle) == {"class": ["handle"]}

    semantics.add_update_semantics(prim, "mug")
    assert semantics.get_labels(prim) == {"class": ["mug"]}
    semantics.remove_labels(prim)
    assert semantics.get_labels(prim) == {}
    assert semantics.get_labels(handle) == {"class": ["handle"]}
    semantics.remove_labels(prim, recursive=True)
    assert semantics.get_labels(handle) == {}


def test_removal_holds_for_other_readers_of_the_saved_file(tmp_path, stage, prim, asset):
    prim.GetReferences().AddReference(asset)
    semantics.remove_labels(prim, recursive=True)
    stage.GetRootLayer().Export(str(tmp_path / "saved.usda"))
    reopened = Usd.Stage.Open(str(tmp_path / "saved.usda"))
    assert reopened.GetPrimAtPath(prim.GetPath())
    for each in reopened.Traverse():
        assert not [name for name in each.GetAppliedSchemas() if name.startswith("Semantics")]
        # Programs that look at attributes alone find no values either.
        values = [attribute.Get() for attribute in each.GetAttributes() if attribute.GetName().startswith("semantic")]
        assert not [value for value in values if value]


def test_a_removed_referenced_label_can_be_added_again(prim, asset):
    prim.GetReferences().AddReference(asset)
    semantics.remove_labels(prim)
    semantics.add_labels(prim, {"class": ["old_mug"]})
    assert semantics.get_labels(prim) == {"class": ["old_mug"]}
    assert ("class", "old_mug") in old_pairs(prim)


def test_instances_are_opened_to_remove_labels_inside(stage, asset):
    instance = stage.DefinePrim("/World/instance", "Xform")
    instance.GetReferences().AddReference(asset)
    instance.SetInstanceable(True)
    proxy = stage.GetPrimAtPath("/World/instance/handle")
    assert semantics.get_labels(proxy) == {"class": ["handle"]}
    with pytest.raises(BadPrim, match="inside an instance"):
        semantics.remove_labels(proxy)
    with pytest.raises(BadPrim, match="inside an instance"):
        semantics.add_labels(proxy, {"class": "x"})
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="/World/instance"):
        semantics.remove_labels(instance, recursive=True)
    assert semantics.get_labels(stage.GetPrimAtPath("/World/instance/handle")) == {}


def test_instances_without_labels_stay_instances(stage):
    stage.DefinePrim("/proto/cube", "Cube")
    instance = stage.DefinePrim("/World/instance", "Xform")
    instance.GetReferences().AddInternalReference("/proto")
    instance.SetInstanceable(True)
    semantics.remove_labels(stage.GetPrimAtPath("/World"), recursive=True)
    assert instance.IsInstance()


def test_a_prim_that_is_gone_is_refused(stage):
    with pytest.raises(BadPrim, match="does not exist"):
        semantics.add_labels(stage.GetPrimAtPath("/nothing"), {"class": "x"})


def test_labels_on_a_geom_subset(stage):
    mesh = UsdGeom.Mesh.Define(stage, "/World/mesh")
    subset = UsdGeom.Subset.Define(stage, mesh.GetPath().AppendChild("lid")).GetPrim()
    semantics.add_labels(subset, {"class": "lid"})
    assert semantics.get_labels(subset) == {"class": ["lid"]}


def test_edits_go_to_the_edit_target(stage, prim):
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        semantics.add_labels(prim, {"class": "x"})
    assert not stage.GetRootLayer().GetPrimAtPath(Sdf.Path("/World/mug")).HasInfo("apiSchemas")
    assert semantics.get_labels(prim) == {"class": ["x"]}


@pytest.mark.parametrize(
    ("kind", "value", "labels"),
    [(Sdf.ValueTypeNames.Token, "mug", ["mug"]), (Sdf.ValueTypeNames.String, "mug", ["mug"])],
)
def test_a_label_authored_alone_is_one_label(stage, prim, kind, value, labels):
    UsdSemantics.LabelsAPI.Apply(prim, "class")
    over = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), prim.GetPath())
    Sdf.AttributeSpec(over, "semantics:labels:class", kind).default = value
    assert semantics.get_labels(prim) == {"class": labels}


def test_labels_that_are_not_strings_are_named(stage, prim):
    forget_warnings()
    UsdSemantics.LabelsAPI.Apply(prim, "class")
    over = Sdf.CreatePrimInLayer(stage.GetSessionLayer(), prim.GetPath())
    Sdf.AttributeSpec(over, "semantics:labels:class", Sdf.ValueTypeNames.Int).default = 5
    with pytest.warns(UsdsdgWarning, match="/World/mug.semantics:labels:class: 5 is not a label"):
        assert not semantics.get_labels(prim).get("class")
