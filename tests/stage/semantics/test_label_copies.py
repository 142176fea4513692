"""The same labels for many prims are what adding them to each prim would be."""

import pytest
from pxr import Sdf, Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.semantics.label_copies import label_all
from usdsdg.stage.semantics.labels import add_labels, get_labels


def made():
    """Prims without anything, with labels, with custom data, with schemas of their own, and one twice."""
    stage = Usd.Stage.CreateInMemory()
    prims = [UsdGeom.Xform.Define(stage, f"/x{k}").GetPrim() for k in range(6)]
    for prim in prims:
        prim.CreateAttribute("replicatorXform", Sdf.ValueTypeNames.Bool, custom=True).Set(True)
    add_labels(prims[2], {"class": ["old"]})
    prims[4].SetCustomDataByKey("mine", 3)
    prims[5].CreateAttribute("semantics:labels:class", Sdf.ValueTypeNames.TokenArray).Set(["of no schema"])
    return stage, [*prims, stage.DefinePrim("/light", "SphereLight"), prims[0]]


@pytest.mark.parametrize(
    "labels", [{"class": ["cube"]}, {"class": ["a b", "a_b"], "no name!": ["x"], "kind": ["y"]}, {}], ids=len
)
@pytest.mark.parametrize("first", [0, 5])
def test_copies_are_what_adding_to_each_gives(labels, first):
    (ours, many), (theirs, each) = made(), made()
    for prims in (many, each):
        prims.insert(0, prims.pop(first))
    label_all(many, labels)
    for prim in each:
        add_labels(prim, labels)
    assert ours.ExportToString() == theirs.ExportToString()
    assert [get_labels(prim) for prim in many] == [get_labels(prim) for prim in each]


def test_prims_inside_of_instances_are_refused():
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/source/part")
    copy = stage.DefinePrim("/copy")
    copy.GetReferences().AddInternalReference("/source")
    copy.SetInstanceable(True)
    with pytest.raises(BadPrim, match="inside an instance"):
        label_all([stage.GetPrimAtPath("/copy/part"), stage.GetPrimAtPath("/source")], {"class": ["cube"]})
