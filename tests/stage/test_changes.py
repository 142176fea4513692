import gc
import weakref

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.stage.change_tracker import KEPT_APART, ChangeTracker, schemas_only
from usdsdg.stage.poses.xform_ops import author_pose
from usdsdg.stage.prims.handles import Handles

ROOT = Sdf.Path.absoluteRootPath


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    author_pose(UsdGeom.Cube.Define(stage, "/World/a").GetPrim(), translate=(0, 0, 0))
    UsdGeom.Cube.Define(stage, "/World/a/b")
    return stage


@pytest.fixture
def tracker(stage):
    tracker = ChangeTracker(stage)
    yield tracker
    tracker.close()


def path(text):
    return Sdf.Path(text)


def facts(changes):
    return changes.resynced, changes.changed, list(changes.handles)


def test_no_edits_are_no_changes(tracker):
    assert facts(tracker.take()) == (set(), {}, [])
    assert not tracker.take()


def test_a_set_attribute_is_named_once(stage, tracker):
    attribute = stage.GetAttributeAtPath("/World/a.xformOp:translate")
    for x in range(5):
        attribute.Set(Gf.Vec3d(x, 0, 0))
    assert facts(tracker.take()) == (set(), {path("/World/a"): {"xformOp:translate"}}, [])
    assert not tracker.take()


def test_registered_properties_are_reported_by_index_unless_prims_are_resynced(stage, tracker):
    handles = Handles()
    handles.note([path("/World/a.xformOp:translate")], 7)
    handles.note([path("/World/b.xformOp:translate")], 8)
    translate = stage.GetAttributeAtPath("/World/a.xformOp:translate")
    translate.Set(Gf.Vec3d(1, 0, 0))
    stage.GetPrimAtPath("/World/a").CreateAttribute("primvars:x", Sdf.ValueTypeNames.Float).Set(1.0)
    changes = tracker.take(handles=handles)
    assert facts(changes) == (set(), {path("/World/a"): {"primvars:x"}}, [7])
    assert set(changes.properties) == {path("/World/a.xformOp:translate"), path("/World/a.primvars:x")}
    translate.Set(Gf.Vec3d(2, 0, 0))
    assert facts(tracker.take(handles=handles)) == (set(), {}, [7])
    translate.Set(Gf.Vec3d(3, 0, 0))
    stage.DefinePrim("/World/New")
    assert tracker.take(handles=handles).changed == {path("/World/a"): {"xformOp:translate"}}


def test_several_attributes_of_several_prims(stage, tracker):
    UsdGeom.Cube(stage.GetPrimAtPath("/World/a")).GetSizeAttr().Set(3.0)
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/a")).MakeInvisible()
    UsdGeom.Cube(stage.GetPrimAtPath("/World/a/b")).GetSizeAttr().Set(3.0)
    changes = tracker.take()
    assert not changes.resynced
    assert changes.changed == {path("/World/a"): {"size", "visibility"}, path("/World/a/b"): {"size"}}


def test_applied_schemas_are_reported_where_they_are_relevant(stage, tracker):
    """A reader may exclude prims where only schemas were edited; their other changes are reported as before."""
    a, b, label = stage.GetPrimAtPath("/World/a"), stage.GetPrimAtPath("/World/a/b"), "SemanticsLabelsAPI:class"
    with schemas_only():
        a.AddAppliedSchema(label)
    assert facts(tracker.take()) == ({path("/World/a")}, {}, [])
    with schemas_only(), schemas_only():
        a.RemoveAppliedSchema(label)
    with schemas_only():
        b.AddAppliedSchema(label)
    asked = []
    changes = tracker.take(is_relevant=lambda prim: asked.append(prim) or prim == path("/World/a/b"))
    assert facts(changes) == ({path("/World/a/b")}, {}, [])
    assert sorted(asked) == [path("/World/a"), path("/World/a/b")]
    with schemas_only():
        a.AddAppliedSchema(label)
    stage.RemovePrim("/World/a")
    assert facts(tracker.take(is_relevant=lambda prim: False)) == ({path("/World/a")}, {}, [])
    assert not tracker.take()


def test_nobody_knows_what_else_was_edited_with_applied_schemas(stage, tracker):
    """As at the end of a block, whose notice names them alone."""
    a, label = stage.GetPrimAtPath("/World/a"), "SemanticsLabelsAPI:class"
    a.AddAppliedSchema(label)
    assert facts(tracker.take(is_relevant=lambda prim: False)) == ({path("/World/a")}, {}, [])
    with Sdf.ChangeBlock(), schemas_only():
        a.RemoveAppliedSchema(label)
    assert facts(tracker.take(is_relevant=lambda prim: False)) == ({path("/World/a")}, {}, [])


def test_a_new_attribute_is_a_change_of_its_prim(stage, tracker):
    stage.GetPrimAtPath("/World/a").CreateAttribute("primvars:x", Sdf.ValueTypeNames.Float)
    assert facts(tracker.take()) == (set(), {path("/World/a"): {"primvars:x"}}, [])


def test_a_removed_attribute_is_a_change_of_its_prim(stage, tracker):
    stage.GetPrimAtPath("/World/a").RemoveProperty("xformOp:translate")
    assert facts(tracker.take()) == (set(), {path("/World/a"): {"xformOp:translate"}}, [])


def test_relationship_targets_are_changes_of_the_relationship(stage, tracker):
    relationship = stage.GetPrimAtPath("/World/a").CreateRelationship("material:binding")
    relationship.AddTarget("/World/a/b")
    relationship.SetTargets(["/World"])
    changes = tracker.take()
    assert facts(changes) == (set(), {path("/World/a"): {"material:binding"}}, [])
    assert changes.properties == [path("/World/a.material:binding")]


@pytest.mark.parametrize(
    "edit",
    [
        lambda stage: stage.DefinePrim("/World/c", "Sphere"),
        lambda stage: stage.GetPrimAtPath("/World/a").SetActive(False),
        lambda stage: stage.GetPrimAtPath("/World/a").SetTypeName("Sphere"),
        lambda stage: stage.GetPrimAtPath("/World/a").GetReferences().AddInternalReference("/World/x"),
        lambda stage: stage.RemovePrim("/World/a"),
    ],
)
def test_structure_is_resynced(stage, tracker, edit):
    stage.DefinePrim("/World/x")
    tracker.take()
    edit(stage)
    changes = tracker.take()
    assert len(changes.resynced) == 1
    assert changes.resynced <= {path("/World/a"), path("/World/c")}
    assert not changes.changed


def test_prims_below_a_resynced_prim_are_not_listed(stage, tracker):
    UsdGeom.Cube(stage.GetPrimAtPath("/World/a/b")).GetSizeAttr().Set(3.0)
    UsdGeom.Cube(stage.GetPrimAtPath("/World/a")).GetSizeAttr().Set(3.0)
    stage.DefinePrim("/World/a/c")
    stage.GetPrimAtPath("/World/a").SetTypeName("Xform")
    assert facts(tracker.take()) == ({path("/World/a")}, {}, [])


def test_metadata_of_the_stage_belongs_to_the_root(stage, tracker):
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    assert facts(tracker.take()) == (set(), {ROOT: set()}, [])


def test_metadata_of_a_prim_names_no_attribute(stage, tracker):
    stage.GetPrimAtPath("/World/a").SetCustomDataByKey("note", "x")
    assert facts(tracker.take()) == (set(), {path("/World/a"): set()}, [])


def test_metadata_is_told_beside_properties(stage, tracker):
    prim = stage.GetPrimAtPath("/World/a")
    prim.CreateAttribute("custom", Sdf.ValueTypeNames.Float)
    tracker.take()
    prim.GetAttribute("custom").Set(1.0)
    assert tracker.take().metadata == frozenset()
    prim.GetAttribute("custom").Set(2.0)
    prim.SetCustomDataByKey("note", "x")
    changes = tracker.take()
    assert changes.changed == {path("/World/a"): {"custom"}}
    assert changes.metadata == {path("/World/a")}


def test_a_replaced_layer_resyncs_everything(stage, tracker):
    stage.GetRootLayer().Clear()
    assert tracker.take().resynced <= {ROOT, path("/World")}


def test_a_change_block_is_one_change(stage, tracker):
    with Sdf.ChangeBlock():
        for name in ("/World/a", "/World/a/b"):
            spec = stage.GetRootLayer().GetPrimAtPath(name)
            Sdf.AttributeSpec(spec, "custom", Sdf.ValueTypeNames.Float).default = 1.0
    assert tracker.take().changed == {path("/World/a"): {"custom"}, path("/World/a/b"): {"custom"}}


def test_muting_one_tracker_leaves_the_other_listening(stage, tracker):
    other = ChangeTracker(stage)
    with tracker.muted(), Sdf.ChangeBlock():
        stage.GetRootLayer().GetAttributeAtPath("/World/a.xformOp:translate").default = Gf.Vec3d(1, 2, 3)
    assert not tracker.take()
    assert other.take().changed == {path("/World/a"): {"xformOp:translate"}}
    UsdGeom.Cube(stage.GetPrimAtPath("/World/a")).GetSizeAttr().Set(3.0)
    assert tracker.take().changed == {path("/World/a"): {"size"}}


def test_muting_nests_and_ends_after_an_exception(stage, tracker):
    size = UsdGeom.Cube(stage.GetPrimAtPath("/World/a")).GetSizeAttr()
    with tracker.muted():
        with tracker.muted():
            pass
        size.Set(3.0)
    assert not tracker.take()
    with pytest.raises(RuntimeError), tracker.muted():
        raise RuntimeError
    size.Set(4.0)
    assert tracker.take()


def test_a_closed_tracker_records_nothing(stage, tracker):
    tracker.close()
    tracker.close()
    stage.DefinePrim("/World/new")
    assert not tracker.take()


def test_a_tracker_without_references_is_freed(stage):
    tracker = ChangeTracker(stage)
    ghost = weakref.ref(tracker)
    del tracker
    gc.collect()
    assert ghost() is None
    stage.DefinePrim("/World/new")


def test_other_stages_are_not_tracked(tracker):
    UsdGeom.Cube.Define(Usd.Stage.CreateInMemory(), "/World/a")
    assert not tracker.take()


def test_a_tracker_outlives_its_stage():
    stage = Usd.Stage.CreateInMemory()
    tracker = ChangeTracker(stage)
    stage.DefinePrim("/a")
    del stage
    gc.collect()
    assert tracker.take().resynced == {path("/a")}
    tracker.close()


def test_readers_that_ask_at_different_times_miss_nothing(stage, tracker):
    """Also one that does not ask for many notices, and one that was told of the same properties before."""
    other, size = ChangeTracker(stage), UsdGeom.Cube(stage.GetPrimAtPath("/World/a")).GetSizeAttr()
    translate = stage.GetAttributeAtPath("/World/a.xformOp:translate")
    for k in range(3 * KEPT_APART):
        size.Set(1.0 + k)
        assert tracker.take().changed == {path("/World/a"): {"size"}}
    translate.Set(Gf.Vec3d(1, 0, 0))
    assert other.take().changed == {path("/World/a"): {"size", "xformOp:translate"}}
    assert tracker.take().changed == {path("/World/a"): {"xformOp:translate"}}
    stage.DefinePrim("/World/new")
    assert facts(other.take()) == facts(tracker.take()) == ({path("/World/new")}, {}, [])
