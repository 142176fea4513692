"""Labels by schema form x instancing x place of the label x kind of edit x time of the edit: as on a fresh stage.

A stage is labeled, read or not, and edited; what annotators then see is what they see on a stage that was authored with
the final labels at once.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSemantics, UsdShade

from tests.sampled_cases import sampled
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.stage.schemas.semantics_schema import SemanticsAPI
from usdsdg.stage.semantics import labels as semantics

ROOM, THING = "/World/room", "/World/room/thing"
FILTERS = (None, "class:*", "class:pear|apple", "class:room")


# --- schema forms: write these labels of a prim, instead of what it has in this form ---


def in_our_way(prim, values):
    semantics.remove_labels(prim)
    if values:
        semantics.add_labels(prim, {"class": list(values)})


def in_the_new_schema(prim, values):
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr().Set(list(values))


def in_the_old_schema(prim, values):
    for api in SemanticsAPI.GetAll(prim):
        prim.RemoveAPI(SemanticsAPI, api.GetName())
    for value in values:
        api = SemanticsAPI.Apply(prim, f"Semantics_{value}")
        api.CreateSemanticTypeAttr().Set("class")
        api.CreateSemanticDataAttr().Set(value)


FORMS = [in_our_way, in_the_new_schema, in_the_old_schema]


# --- instancing: author the stage; return the gprims that are drawn, and where labels can be ---


def mesh(stage, path):
    return UsdGeom.Cube.Define(stage, path)


def no_instance(stage):
    mesh(stage, f"{THING}/mesh")
    mesh(stage, f"{THING}/other")
    return [f"{THING}/mesh", f"{THING}/other"], f"{THING}/mesh", THING


def reference(stage):
    mesh(stage, "/Asset/mesh")
    thing = stage.DefinePrim(THING, "Xform")
    thing.GetReferences().AddInternalReference("/Asset")
    return [f"{THING}/mesh"], "/Asset/mesh", THING


def scene_instances(stage):
    mesh(stage, "/Asset/mesh")
    for name in ("thing", "twin"):
        prim = stage.DefinePrim(f"{ROOM}/{name}", "Xform")
        prim.GetReferences().AddInternalReference("/Asset")
        prim.SetInstanceable(True)
    return [f"{ROOM}/thing/mesh", f"{ROOM}/twin/mesh"], "/Asset/mesh", THING


def nested_instances(stage):
    mesh(stage, "/Inner/mesh")
    inner = stage.DefinePrim("/Asset/part", "Xform")
    inner.GetReferences().AddInternalReference("/Inner")
    inner.SetInstanceable(True)
    thing = stage.DefinePrim(THING, "Xform")
    thing.GetReferences().AddInternalReference("/Asset")
    thing.SetInstanceable(True)
    return [f"{THING}/part/mesh"], "/Inner/mesh", "/Asset/part"


def points(stage, home, parent):
    instancer = UsdGeom.PointInstancer.Define(stage, parent)
    prototype = UsdGeom.Xform.Define(stage, home)
    mesh(stage, f"{home}/mesh")
    instancer.CreatePrototypesRel().SetTargets([prototype.GetPath()])
    instancer.CreateProtoIndicesAttr([0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0)])
    return [f"{home}/mesh[0]", f"{home}/mesh[1]"], f"{home}/mesh", home


def point_instances_below(stage):
    return points(stage, f"{ROOM}/points/thing", f"{ROOM}/points")


def point_instances_elsewhere(stage):
    return points(stage, "/Library/thing", f"{ROOM}/points")


INSTANCING = [
    no_instance, reference, scene_instances, nested_instances, point_instances_below, point_instances_elsewhere,
]  # fmt: skip
PLACES = ["gprim", "parent", "ancestor", "material", "gprim below a labeled ancestor"]


def author(instancing: Callable, place: str) -> tuple[Usd.Stage, list[str], Usd.Prim]:
    """Return a stage without labels (but of the ancestor), its gprims, and the prim to label."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, ROOM)
    gprims, gprim, parent = instancing(stage)
    at = {"parent": parent, "ancestor": ROOM}.get(place, gprim)
    if place == "material":
        at = "/Looks/skin"
        material = UsdShade.Material.Define(stage, at)
        UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(gprim)).Bind(material)
    if place == "gprim below a labeled ancestor":
        semantics.add_labels(stage.GetPrimAtPath(ROOM), {"class": "room"})
    return stage, gprims, stage.GetPrimAtPath(at)


# --- edits, and the labels after them; the first label is "apple" ---


def relabel(prim, form):
    form(prim, ["pear"])
    return ["pear"]


def add_one(prim, form):
    form(prim, ["apple", "pear"])
    return ["apple", "pear"]


def remove(prim, form):
    form(prim, [])
    return []


def relabel_in_our_way(prim, form):
    semantics.add_labels(prim, {"class": "pear"}, mode="replace")
    return ["pear"]


def add_in_our_way(prim, form):
    semantics.add_labels(prim, {"class": "pear"})
    return ["apple", "pear"]


def remove_in_our_way(prim, form):
    semantics.remove_labels(prim)
    return []


def remove_and_label_again(prim, form):
    form(prim, [])
    form(prim, ["pear"])
    return ["pear"]


def in_a_stronger_layer(prim, form):
    stage = prim.GetStage()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        form(prim, ["pear"])
    return ["pear"] if form is not in_the_old_schema else None


def deactivated_and_back(prim, form):
    prim.SetActive(False)
    prim.SetActive(True)
    return ["apple"]


EDITS = [
    relabel, add_one, remove, relabel_in_our_way, add_in_our_way, remove_in_our_way, remove_and_label_again,
    in_a_stronger_layer, deactivated_and_back,
]  # fmt: skip


def seen(reader: LabeledPrimReader, gprims: list[str], time: Usd.TimeCode | None = None) -> dict:
    """Return for each filter and gprim the name of its owner and the labels that annotators report."""
    found = reader.read(gprims, FILTERS, time=time)
    told = {}
    for predicate in FILTERS:
        selection = found.select(predicate)
        for gprim, member in zip(gprims, selection.member_of_gprim.tolist(), strict=True):
            owner = found.prim_paths[selection.rows[member]] if member >= 0 else None
            told[predicate, gprim] = owner, selection.labels[member] if member >= 0 else None
    return told


def fresh(instancing: Callable, place: str, form: Callable, values: list[str]) -> dict:
    stage, gprims, prim = author(instancing, place)
    if values:
        form(prim, values)
    return seen(LabeledPrimReader(stage), gprims)


def cells() -> Iterator[tuple]:
    return itertools.product(FORMS, EDITS, ["before the first frame", "between frames"])


@pytest.mark.filterwarnings("ignore:.*selects none of the labels")
@pytest.mark.parametrize("place", sampled(PLACES, 2))
@pytest.mark.parametrize("instancing", INSTANCING, ids=lambda each: each.__name__)
def test_labels_after_an_edit_are_those_of_a_fresh_stage(instancing, place):
    for form, edit, when in cells():
        stage, gprims, prim = author(instancing, place)
        form(prim, ["apple"])
        reader = LabeledPrimReader(stage)
        if when == "between frames":
            assert seen(reader, gprims) == fresh(instancing, place, form, ["apple"])
        values = edit(prim, form)
        if values is None:
            continue
        found = seen(reader, gprims)
        expected = fresh(instancing, place, form, values)
        assert found == expected, (form.__name__, edit.__name__, when)
        carriers = [labels for _, labels in found.values() if labels]
        assert bool(carriers) == bool(values or place == "gprim below a labeled ancestor")


@pytest.mark.filterwarnings("ignore:.*selects none of the labels")
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("instancing", INSTANCING, ids=lambda each: each.__name__)
def test_labels_that_are_time_samples_are_those_of_a_fresh_stage_at_each_time(instancing, place):
    stage, gprims, prim = author(instancing, place)
    attribute = UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr()
    for code, values in ((0, ["apple"]), (10, ["pear"]), (20, [])):
        attribute.Set(values, code)
    reader = LabeledPrimReader(stage)
    for code, values in ((0, ["apple"]), (10, ["pear"]), (20, []), (5, ["apple"]), (15, ["pear"])):
        found = seen(reader, gprims, Usd.TimeCode(code))
        assert found == fresh(instancing, place, in_the_new_schema, values), code


# --- metamorphic: what changes no label ---


@pytest.mark.filterwarnings("ignore:.*selects none of the labels")
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("instancing", INSTANCING, ids=lambda each: each.__name__)
def test_an_empty_label_on_every_unlabeled_prim_changes_nothing(instancing, place):
    stage, gprims, prim = author(instancing, place)
    in_our_way(prim, ["apple"])
    before = seen(LabeledPrimReader(stage), gprims)
    for each in list(stage.TraverseAll()):
        if not semantics.get_labels(each) and each.GetPath() != Sdf.Path("/"):
            UsdSemantics.LabelsAPI.Apply(each, "class")
            if each.GetName() != "other":
                UsdSemantics.LabelsAPI(each, "class").CreateLabelsAttr().Set(["", " "])
    assert seen(LabeledPrimReader(stage), gprims) == before


@pytest.mark.filterwarnings("ignore:.*selects none of the labels")
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("instancing", [no_instance, reference, scene_instances, nested_instances])
def test_flattening_and_making_instances_editable_changes_nothing(instancing, place):
    stage, gprims, prim = author(instancing, place)
    in_our_way(prim, ["apple"])
    before = seen(LabeledPrimReader(stage), gprims)
    whole = Usd.Stage.Open(stage.Flatten())
    assert seen(LabeledPrimReader(whole), gprims) == before
    for path in ("/Asset/part", THING, f"{ROOM}/twin"):
        if stage.GetPrimAtPath(path) and stage.GetPrimAtPath(path).IsInstance():
            stage.GetPrimAtPath(path).SetInstanceable(False)
    assert seen(LabeledPrimReader(stage), gprims) == before
