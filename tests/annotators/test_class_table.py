"""The class table of a dataset: what fixes it, what it follows from, and that parts of a dataset agree."""

import json

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade

import usdsdg as rep
from usdsdg import errors
from usdsdg.errors import UsdsdgWarning
from usdsdg.session import session
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.stage.semantics.labels import add_labels

FRUIT = ["plum", "apple", "pear", "fig"]


@pytest.fixture
def fruit(stage):
    """Four cubes, in a row along x."""
    return [
        rep.functional.create.cube(position=(x, 0, 0), scale=0.4, semantics={"class": name}, parent="/World")
        for x, name in enumerate(FRUIT)
    ]


@pytest.fixture
def product(stage):
    camera = rep.functional.create.camera(position=(1.5, -8, 0), look_at=(1.5, 0, 0), parent="/World")
    return rep.create.render_product(camera, (64, 48))


def masks(product, **params):
    """Capture a frame; return the ids of semantic_segmentation and their labels."""
    seen = rep.annotators.get("semantic_segmentation", init_params={"semanticFilter": "class:*", **params})
    seen.attach(product)
    rep.orchestrator.step()
    return seen.get_data()


def ids(product, **params):
    """Return the id of each class that is in the table of ids, by label."""
    table = masks(product, **params)["info"]["idToLabels"]
    return {labels["class"]: int(number) for number, labels in table.items() if labels["class"].islower()}


def test_ids_follow_the_names_and_not_the_stage(fruit, product):
    assert ids(product) == {"apple": 2, "fig": 3, "pear": 4, "plum": 5}


def test_classes_that_are_given_have_their_place_and_their_color(fruit, product):
    rep.settings.set_semantic_classes({"Pear": {"id": 7, "color": (1, 2, 3)}, "apple": 2, "plum": {}, "fig": None})
    assert ids(product) == {"pear": 7, "apple": 2, "plum": 3, "fig": 4}
    seen = masks(product, colorize=True)
    assert seen["info"]["idToLabels"]["(1, 2, 3, 255)"] == {"class": "pear"}
    assert (seen["data"].reshape(-1, 4) == (1, 2, 3, 255)).all(axis=1).any()


def test_a_class_that_is_not_given_is_appended_with_a_warning(fruit, product):
    rep.settings.set_semantic_classes(["pear", "plum"])
    with pytest.warns(errors.UsdsdgWarning, match="'apple', 'fig' is not among semantic_classes"):
        assert ids(product) == {"pear": 2, "plum": 3, "apple": 4, "fig": 5}


def test_a_closed_table_refuses_other_classes(fruit, product):
    rep.settings.set_semantic_classes(["pear", "plum", "fig"], closed=True)
    with pytest.raises(errors.ConfigError, match=r"'apple' is not in the class table.*List it in semantic_classes"):
        ids(product)


def test_a_closed_table_that_follows_from_the_stage_refuses_later_names(fruit, product):
    get_settings().set("/usdsdg/labels/closedClasses", True)
    assert ids(product)["apple"] == 2
    rep.functional.create.cube(position=(0, 0, 1), scale=0.4, semantics={"class": "banana"}, parent="/World")
    with pytest.raises(errors.ConfigError, match="'banana' is not in the class table"):
        ids(product)


def test_names_that_come_up_later_are_appended(fruit, product):
    before = ids(product)
    rep.functional.create.cube(position=(0, 0, 1), scale=0.4, semantics={"class": "aardvark"}, parent="/World")
    assert ids(product) == {**before, "aardvark": 6}


def test_fifty_frames_of_things_that_come_and_go_have_one_id_and_one_color_for_each_class(fruit, product):
    rng, names = np.random.default_rng(5), [*FRUIT, "quince", "aardvark"]
    ids = rep.annotators.get("semantic_segmentation", init_params={"semanticFilter": "class:*"})
    colors = rep.annotators.get("semantic_segmentation", init_params={"semanticFilter": "class:*", "colorize": True})
    ids.attach(product)
    colors.attach(product)
    things, found, seen = list(fruit), {}, set()
    for k in range(50):
        UsdGeom.Imageable(things[k % len(things)]).GetVisibilityAttr().Set(["inherited", "invisible"][k // 7 % 2])
        if k % 3 == 0:
            things.remove(thing := things[rng.integers(len(things))])
            current_stage().RemovePrim(thing.GetPath())
        if k % 3 != 1 and len(things) < 6:
            at, name = (rng.uniform(-1, 4), 0, rng.uniform(-1.5, 1.5)), names[rng.integers(len(names))]
            made = rep.functional.create.cube(position=at, scale=0.4, semantics={"class": name}, parent="/World")
            things.append(made)
        rep.orchestrator.step()
        by_id, by_color = ids.get_data(), colors.get_data()
        pixels = by_color["data"].view(np.uint8).reshape(*by_id["data"].shape[:2], 4)
        for number in np.unique(by_id["data"]):
            color = np.unique(pixels[by_id["data"] == number], axis=0)
            assert len(color) == 1
            label = by_id["info"]["idToLabels"][str(number)]["class"]
            assert by_color["info"]["idToLabels"][str(tuple(map(int, color[0])))]["class"] == label
            assert found.setdefault(label, (number, tuple(color[0]))) == (number, tuple(color[0]))
            seen.add(label)
    assert seen >= {*names}
    assert len(set(found.values())) == len(found)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (["pear", "Pear"], "two entries are the same class"),
        ({"pear": 2, "apple": 2}, "two entries have one id"),
        ({"pear": 1}, "expected 2 to 65535"),
        ({"pear": {"color": (0, 0, 0)}}, "is black"),
        ({"pear": {"color": (0, 0)}}, "expected .r, g, b."),
        ([3], "is not a class"),
        (17, "expected names"),
        ({"apple": "red"}, "'apple' has 'red'; expected names"),
        ({"apple": [2]}, r"'apple' has \[2\]; expected names"),
        ({"tables": [{"labels": {}}]}, "a table without classes"),
        ("x" * 300, "File name too long"),
        ("/nowhere/classes.json", "cannot be read"),
    ],
)
def test_classes_that_cannot_be(stage, given, reason):
    with pytest.raises(errors.ConfigError, match=reason):
        rep.settings.set_semantic_classes(given)


def test_class_files(fruit, product, tmp_path):
    for name, text in (
        ("classes.txt", "# of the orchard\npear\n\nclass:fig\n"),
        ("classes.json", '["pear", "fig"]'),
        ("classes.yaml", "pear:\nfig:\n"),
    ):
        (tmp_path / name).write_text(text)
        rep.settings.set_semantic_classes(tmp_path / name)
        errors.forget_warnings()
        with pytest.warns(errors.UsdsdgWarning, match="is not among semantic_classes"):
            assert ids(product) == {"pear": 2, "fig": 3, "apple": 4, "plum": 5}


def test_without_stable_ids_each_frame_counts_what_it_shows(fruit, product):
    get_settings().set("/usdsdg/labels/stableIds", False)
    assert ids(product) == {"plum": 2, "apple": 3, "pear": 4, "fig": 5}  # in stage order
    UsdGeom.Imageable(fruit[0]).MakeInvisible()
    assert ids(product) == {"apple": 2, "pear": 3, "fig": 4}
    get_settings().set("/usdsdg/labels/stableIds", True)
    assert ids(product) == {"apple": 2, "fig": 3, "pear": 4}


# What the graph can bring


def written(folder):
    return json.loads((folder / ".usdsdg" / "classes.json").read_text())["tables"]


def names(folder):
    """Return the names in a class file by id."""
    [table] = written(folder)
    return {each["id"]: each["name"] for each in table["classes"]}


def write_one_frame(folder, product):
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=str(folder), semantic_segmentation=True)
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()


def labelled_asset(path, name):
    stage = Usd.Stage.CreateNew(str(path))
    root = UsdGeom.Xform.Define(stage, "/Root").GetPrim()
    stage.SetDefaultPrim(root)
    add_labels(UsdGeom.Cube.Define(stage, "/Root/Cube").GetPrim(), {"class": [name]})
    stage.Save()
    return str(path)


@pytest.mark.parametrize("mode", ["scene_instance", "reference", "point_instance"])
@pytest.mark.parametrize("use_cache", [True, False])
def test_assets_that_may_be_drawn_have_ids_before_they_are(stage, product, tmp_path, mode, use_cache):
    files = [labelled_asset(tmp_path / f"{name}.usda", name) for name in ("nut", "bolt", "gear")]
    with rep.trigger.on_frame():
        rep.randomizer.instantiate(files, size=1, mode=mode, use_cache=use_cache)
    write_one_frame(tmp_path / "out", product)
    assert names(tmp_path / "out") == {2: "bolt", 3: "gear", 4: "nut"}


def test_labels_that_a_node_will_write_have_ids_before(fruit, product, tmp_path):
    with rep.trigger.on_frame(interval=100), rep.get.prims(path_pattern="/World/Cube$"):
        rep.modify.semantics([("class", "banana")])
    with rep.trigger.on_custom_event("ripe"), rep.get.prims(path_pattern="/World/Cube$"):
        rep.modify.semantics([("class", "ripe")], mode="replace")
    write_one_frame(tmp_path / "out", product)
    # The first trigger has fired already.
    assert {"plum,banana", "ripe", "ripe,banana", "apple", "pear", "fig"} == set(names(tmp_path / "out").values())


def test_materials_and_variants_that_may_be_shown_have_ids_before(stage, product, tmp_path):
    prim = rep.functional.create.cube(scale=0.4, parent="/World", name="Thing")
    for name in ("wood", "steel"):
        add_labels(UsdShade.Material.Define(stage, f"/Looks/{name}").GetPrim(), {"class": [name]})
    variants = prim.GetVariantSets().AddVariantSet("age")
    for name in ("new", "old"):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            UsdGeom.Sphere.Define(stage, "/World/Thing/Knob")
            add_labels(stage.GetPrimAtPath("/World/Thing/Knob"), {"class": [f"{name} knob"]})
    variants.SetVariantSelection("new")
    with rep.trigger.on_frame(), rep.get.prims(path_pattern="/World/Thing$"):
        rep.randomizer.materials(["/Looks/wood", "/Looks/steel"])
        rep.modify.variant("age", rep.distribution.choice(["new", "old"]))
    write_one_frame(tmp_path / "out", product)
    assert {"wood", "steel", "new knob", "old knob"} <= set(names(tmp_path / "out").values())


# Parts of a dataset


def split(folder, seed, hidden):
    """Make a part of a dataset in which some classes are never seen; return its masks' tables and its class file."""
    session.restart()
    new_stage()
    rep.set_global_seed(seed)
    order = np.random.default_rng(seed).permutation(len(FRUIT))
    for x in order:
        cube = rep.functional.create.cube(position=(float(x), 0, 0), scale=0.4, semantics={"class": FRUIT[x]})
        if FRUIT[x] in hidden:
            UsdGeom.Imageable(cube).MakeInvisible()
    camera = rep.functional.create.camera(position=(1.5, -8, 0), look_at=(1.5, 0, 0))
    write_one_frame(folder, rep.create.render_product(camera, (64, 48)))
    colors = json.loads((folder / "semantic_segmentation_labels_0000.json").read_text())
    return {labels["class"]: color for color, labels in colors.items()}, (folder / ".usdsdg/classes.json").read_bytes()


def test_splits_with_other_seeds_and_other_visible_classes_agree(stage, tmp_path):
    first, first_file = split(tmp_path / "train", 1, hidden=("plum", "pear"))
    second, second_file = split(tmp_path / "val", 2, hidden=("apple", "fig"))
    everything, _ = split(tmp_path / "all", 3, hidden=())
    assert first_file == second_file
    assert first.items() | second.items() == everything.items()
    assert len(everything) == len(FRUIT) + 2


def test_a_dataset_fixes_the_classes_of_another(fruit, product, tmp_path):
    rep.settings.set_semantic_classes({"pear": 9, "fig": 8, "plum": 7, "apple": {"id": 6, "color": [9, 9, 9]}})
    write_one_frame(tmp_path / "train", product)
    before = written(tmp_path / "train")
    rep.settings.set_semantic_classes(None)
    assert ids(product)["apple"] == 2
    rep.settings.set_semantic_classes(tmp_path / "train")
    write_one_frame(tmp_path / "val", product)
    assert written(tmp_path / "val") == before


def test_a_writer_that_goes_on_with_a_new_stage_keeps_its_classes(stage, tmp_path):
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), semantic_segmentation=True)
    for name in ("pear", "apple"):
        new_stage()
        rep.functional.create.cube(scale=0.4, semantics={"class": name})
        camera = rep.functional.create.camera(position=(0, -8, 0), look_at=(0, 0, 0))
        writer.attach(rep.create.render_product(camera, (64, 48)))
        rep.orchestrator.step()
        rep.orchestrator.wait_until_complete()
    assert names(tmp_path) == {2: "pear", 3: "apple"}


def stage_of(name):
    """Make a new stage with one object; return its render product."""
    new_stage()
    rep.functional.create.cube(scale=0.4, semantics={"class": name})
    camera = rep.functional.create.camera(position=(0, -8, 0), look_at=(0, 0, 0))
    return rep.create.render_product(camera, (64, 48))


def capture(writer, folder, product):
    if not writer.num_written:
        writer.initialize(output_dir=str(folder), semantic_segmentation=True)
    writer.attach(product)
    rep.orchestrator.step()
    writer.detach()
    rep.orchestrator.wait_until_complete()


def test_a_writer_that_is_attached_again_has_no_classes_of_stages_before(stage, tmp_path):
    writers = {name: rep.WriterRegistry.get("BasicWriter") for name in ("pear", "apple")}
    for name, writer in writers.items():
        product = stage_of(name)
        for _ in range(3):
            capture(writer, tmp_path / name, product)
        assert names(tmp_path / name) == {2: name}
    product = stage_of("fig")
    for name, writer in writers.items():  # each goes on with its own
        capture(writer, tmp_path / name, product)
    assert {name: names(tmp_path / name) for name in writers} == {name: {2: name, 3: "fig"} for name in writers}


def test_a_writer_of_stages_before_that_changes_the_ids_of_another_is_named(stage, tmp_path):
    first, second = (rep.WriterRegistry.get("BasicWriter") for _ in range(2))
    capture(first, tmp_path / "first", stage_of("pear"))
    product = stage_of("apple")
    second.initialize(output_dir=str(tmp_path / "second"), semantic_segmentation=True)
    second.attach(product)
    rep.orchestrator.step()
    with pytest.warns(UsdsdgWarning, match="goes on with the classes of a stage before, .* BasicWriter has begun"):
        first.attach(product)


def test_coco_has_the_given_classes_as_categories(fruit, product, tmp_path):
    rep.settings.set_semantic_classes({"pear": {"id": 9, "color": [200, 10, 10]}, "fig": {}, "plum": {}, "apple": {}})
    writer = rep.WriterRegistry.get("CocoWriter")
    writer.initialize(output_dir=str(tmp_path / "coco"))
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
    rep.orchestrator.wait_until_complete()
    [file] = (tmp_path / "coco").glob("coco_annotations_*.json")
    coco = json.loads(file.read_text())
    assert {each["id"]: each["name"] for each in coco["categories"]} == {9: "pear", 2: "fig", 3: "plum", 4: "apple"}
    assert {each["category_id"] for each in coco["annotations"]} == {9, 2, 3, 4}
