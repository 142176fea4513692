"""Whatever wrote a prim's labels and however they are changed later, they are those of a stage authored fresh."""

import itertools
import random

import pytest
from pxr import Sdf, Tf, Usd, UsdSemantics

from usdsdg.stage.schemas.semantics_schema import SemanticsAPI
from usdsdg.stage.semantics import label_schemas
from usdsdg.stage.semantics import labels as semantics
from usdsdg.stage.semantics.labels import add_labels, add_update_semantics, get_labels, remove_labels

PATH = "/World/thing"


def by_us(prim, label):
    semantics.add_labels(prim, {"class": label})


def by_new_schema(prim, label):
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr().Set([label])


def by_old_schema(prim, label):
    api = SemanticsAPI.Apply(prim, "Semantics_x")
    api.CreateSemanticTypeAttr().Set("class")
    api.CreateSemanticDataAttr().Set(label)


def by_both_schemas(prim, label):
    by_new_schema(prim, label)
    by_old_schema(prim, label)


WRITERS = [by_us, by_new_schema, by_old_schema, by_both_schemas]


def old_data(prim):
    """Return the attributes of the old schema's labels."""
    return [api.GetSemanticDataAttr() for api in SemanticsAPI.GetAll(prim)]


# Changes to the label "pear", each with the schemas that must be there for it.
def replaced_by_us(prim):
    semantics.add_labels(prim, {"class": "pear"}, mode="replace")


def set_by_new_schema(prim):
    UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Set(["pear"])


def applied_by_new_schema(prim):
    by_new_schema(prim, "pear")


def set_in_old_schema(prim):
    for attribute in old_data(prim):
        attribute.Set("pear")


# Changes to no label.
def removed_by_us(prim):
    semantics.remove_labels(prim)


def removed_new_schema(prim):
    prim.RemoveAPI(UsdSemantics.LabelsAPI, "class")


def blocked_new_schema(prim):
    UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Block()


def emptied_new_schema(prim):
    UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Set([])


def removed_old_schema(prim):
    for api in SemanticsAPI.GetAll(prim):
        prim.RemoveAPI(SemanticsAPI, api.GetName())


def emptied_old_schema(prim):
    for attribute in old_data(prim):
        attribute.Set("")


SET = [replaced_by_us, set_by_new_schema, applied_by_new_schema, set_in_old_schema]
EMPTY = [
    removed_by_us, removed_new_schema, blocked_new_schema, emptied_new_schema, removed_old_schema, emptied_old_schema,
]  # fmt: skip


def needed(edit):
    return (
        {"new"}
        if "new_schema" in edit.__name__ and edit is not applied_by_new_schema
        else ({"old"} if "old_schema" in edit.__name__ else set())
    )


def given(writer):
    return {by_new_schema: {"new"}, by_old_schema: {"old"}}.get(writer, {"new", "old"})


# Where both schemas were written by other means in one layer, nothing tells which of two labels was written later: the
# new schema counts.
def unclear(writer, edit, place):
    return writer is by_both_schemas and edit in (set_in_old_schema, *EMPTY) and (edit is not removed_by_us)


CASES = [
    (writer, edit, place)
    for writer, edit, place in itertools.product(WRITERS, [*SET, *EMPTY], ["same layer", "stronger layer", "reference"])
    if needed(edit) <= given(writer) and not unclear(writer, edit, place)
]


@pytest.mark.parametrize(("writer", "edit", "place"), CASES, ids=lambda each: getattr(each, "__name__", each))
def test_an_edit_gives_the_labels_of_a_fresh_stage(writer, edit, place):
    stage = Usd.Stage.CreateInMemory()
    keep = None
    if place == "same layer":
        prim = stage.DefinePrim(PATH)
        writer(prim, "apple")
    elif place == "stronger layer":
        keep = Sdf.Layer.CreateAnonymous(".usda")
        stage.GetRootLayer().subLayerPaths.append(keep.identifier)
        stage.SetEditTarget(keep)
        writer(stage.DefinePrim(PATH), "apple")
        stage.SetEditTarget(stage.GetRootLayer())
        prim = stage.GetPrimAtPath(PATH)
    else:
        keep = Sdf.Layer.CreateAnonymous(".usda")
        source = Usd.Stage.Open(keep)
        writer(source.DefinePrim("/Asset"), "apple")
        prim = stage.DefinePrim(PATH)
        prim.GetReferences().AddReference(keep.identifier, "/Asset")
    assert semantics.get_labels(prim) == {"class": ["apple"]}
    edit(prim)
    assert semantics.get_labels(prim) == ({"class": ["pear"]} if edit in SET else {})


@pytest.mark.parametrize("first", WRITERS, ids=lambda each: each.__name__)
def test_our_edits_leave_both_schemas_with_one_truth(first):
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim(PATH)
    first(prim, "apple")
    set_by = {"new": set_by_new_schema, "old": set_in_old_schema}
    set_by["new" if first is not by_old_schema else "old"](prim)
    semantics.add_labels(prim, {"class": "fruit"})
    assert semantics.get_labels(prim) == {"class": ["pear", "fruit"]}
    assert list(UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Get()) == ["pear", "fruit"]
    assert {attribute.Get() for attribute in old_data(prim) if attribute.Get()} == {"pear", "fruit"}


def test_another_instance_of_the_old_schema_is_another_label():
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim(PATH)
    semantics.add_labels(prim, {"class": "apple"})
    by_old_schema(prim, "fruit")
    assert semantics.get_labels(prim) == {"class": ["apple", "fruit"]}


def test_types_do_not_touch_each_other():
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim(PATH)
    semantics.add_labels(prim, {"class": "apple", "color": "red", "my type": "x"})
    set_by_new_schema(prim)
    assert semantics.get_labels(prim) == {"class": ["pear"], "color": ["red"], "my type": ["x"]}
    removed_new_schema(prim)
    assert semantics.get_labels(prim) == {"color": ["red"], "my type": ["x"]}


def edit_at_random(stage: Usd.Stage, rng: random.Random) -> None:
    """Label a prim in one of two layers, mostly with what it has, or edit one of the schemas by other means."""
    prim = stage.GetPrimAtPath(f"/{rng.choice('ab')}")
    layer = rng.choice([stage.GetRootLayer(), stage.GetSessionLayer()])
    with Usd.EditContext(stage, layer):
        labels = {rng.choice(["class", "color"]): rng.sample(["red", "mug", "a b"], rng.randint(1, 2))}
        match rng.randint(0, 7):
            case 0:
                add_update_semantics(prim, rng.choice(["red", "mug"]), suffix=rng.choice(["", "_2"]))
            case 1:
                UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr().Set(["by hand"])
            case 2:
                remove_labels(prim)
            case _:
                add_labels(prim, labels, mode=rng.choice(["add", "add", "replace", "clear"]))


@pytest.mark.parametrize("seed", range(20))
def test_labels_that_are_there_need_not_be_written_again(seed, monkeypatch):
    results = []
    for is_always_written in (False, True):
        with monkeypatch.context() as patched:
            if is_always_written:
                patched.setattr(label_schemas, "is_written", lambda *_: False)
            rng, stage = random.Random(seed), Usd.Stage.CreateInMemory()
            for name in "ab":
                stage.DefinePrim(f"/{name}")
            seen = []
            for _ in range(40):
                edit_at_random(stage, rng)
                seen.append([get_labels(prim) for prim in stage.Traverse()])
            results.append(seen)
    assert results[0] == results[1]


def test_labels_that_are_there_edit_nothing():
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/a")
    add_labels(prim, {"class": ["mug", "cup"], "a type": ["x"]})
    before = stage.GetRootLayer().ExportToString()
    seen = []
    listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, lambda notice, sender: seen.append(notice), stage)
    for mode in ("add", "replace"):
        add_labels(prim, {"class": ["mug", "cup"]}, mode=mode)
    listener.Revoke()
    assert seen == []
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        add_labels(prim, {"class": ["mug", "cup"]})
    assert stage.GetSessionLayer().GetAttributeAtPath("/a.semantics:labels:class") is not None
    assert stage.GetRootLayer().ExportToString() == before
