"""CocoWriter: held against the masks of the frame, and against what COCO's own library asks of a file."""

import dataclasses
import inspect
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import add_cube, known, make_frame, new_stage
from tests.annotators.scenes import mask_of, street
from tests.dataset_files import data_names
from tests.writers.formats.shapes.test_run_length import decoded
from usdsdg import annotators, writers
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.writers import spool
from usdsdg.writers.formats.coco.coco_categories import Categories

ROOT = Path(__file__).resolve().parents[4]
PRODUCT = "/Render/HydraTextures/rp1"
FRUIT = {
    "Apple": {"name": "apple", "id": 7, "supercategory": "fruit", "color": [10, 200, 30], "isthing": 1},
    "pear": {"name": "pear", "id": 3},
}


def write(folder, frames, **options):
    """Write `frames` (one, or {path: frame} each time), detach, and return the folder that was written to."""
    writer = writers.get("CocoWriter", init_params={"output_dir": str(folder / "coco"), **options})
    sets = [f if isinstance(f, dict) else {PRODUCT: f} for f in (frames if isinstance(frames, list) else [frames])]
    writer.attach(known(*sets[0]))
    for each in sets:
        writer.receive(annotators.build_payload(writer, each))
    writer.detach()
    writer.backend.wait_until_done()
    return Path(writer.backend.output_dir)


def read(folder):
    (path,) = folder.glob("coco_annotations_*.json")
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48), filters=["class:*;coco:*;stuff:*;thing:*"])


@pytest.fixture(scope="module")
def fruit(frame, tmp_path_factory):
    known(PRODUCT)
    return write(tmp_path_factory.mktemp("fruit"), [frame, frame], coco_categories=FRUIT, dataset_id="set")


SEEN = ["/World/Apple1", "/World/Apple2", "/World/Pear"]  # labeled and not hidden, in the order of the stage


def test_names_of_files(fruit):
    names = data_names(fruit)
    pictures = [f"rp1/{kind}_World-Camera_set.{n:04d}.png" for kind in ("panoptic", "rgb") for n in (0, 1)]
    assert names == ["coco_annotations_set.json", "metadata.txt", *pictures]


def test_masks_areas_and_boxes_are_those_of_the_picture(fruit, frame):
    data = read(fruit)
    assert [image["id"] for image in data["images"]] == [0, 1]
    for image in data["images"]:
        records = [each for each in data["annotations"] if each["image_id"] == image["id"]]
        assert len(records) == len(SEEN)
        for path, record in zip(SEEN, records):
            mask = mask_of(frame, path)
            assert record["segmentation"]["size"] == [48, 64]
            np.testing.assert_array_equal(decoded(record["segmentation"]["counts"], mask.shape), mask)
            rows, columns = np.nonzero(mask)
            assert record["area"] == mask.sum()
            assert record["bbox"] == [
                columns.min(), rows.min(), columns.max() + 1 - columns.min(), rows.max() + 1 - rows.min()
            ]  # fmt: skip
            assert (record["iscrowd"], record["bbox_mode"]) == (0, 1)


def test_the_file_is_consistent(fruit):
    """What pycocotools and COCO's evaluation need."""
    data = read(fruit)
    numbers = [each["id"] for each in data["annotations"]]
    assert numbers == list(range(1, len(numbers) + 1)), "unique, and not 0, which evaluation takes for no match"
    assert {each["image_id"] for each in data["annotations"]} <= {each["id"] for each in data["images"]}
    assert {each["category_id"] for each in data["annotations"]} == {each["id"] for each in data["categories"]}
    for image in data["images"]:
        with Image.open(fruit / image["file_name"]) as picture:
            assert picture.size == (image["width"], image["height"]) == (64, 48)


def test_coco_s_own_library_finds_it_perfect(fruit):
    coco = pytest.importorskip("pycocotools.coco")
    evaluation = pytest.importorskip("pycocotools.cocoeval")
    truth = coco.COCO(str(next(fruit.glob("*.json"))))
    found = [
        {key: each[key] for key in ("image_id", "category_id", "segmentation")} | {"score": 1.0}
        for each in truth.anns.values()
    ]
    for kind in ("segm", "bbox"):
        # It adds boxes to what it is given, as arrays, which it refuses the next time.
        judged = evaluation.COCOeval(truth, truth.loadRes([dict(each) for each in found]), kind)
        judged.evaluate()
        judged.accumulate()
        judged.summarize()
        assert judged.stats[0] == 1.0


def test_categories_are_those_that_were_given(fruit):
    data = read(fruit)
    by_id = {each["id"]: each for each in data["categories"]}
    assert by_id[7] == FRUIT["Apple"]
    assert (by_id[3]["supercategory"], by_id[3]["isthing"], len(by_id[3]["color"])) == ("pear", 1, 3)
    assert [each["category_id"] for each in data["annotations"][:3]] == [7, 7, 3]


def test_pixels_have_the_color_of_their_category(fruit, frame):
    with Image.open(fruit / "rp1/panoptic_World-Camera_set.0000.png") as image:
        colors = np.asarray(image)
    pear = next(each["color"] for each in read(fruit)["categories"] if each["name"] == "pear")
    assert (colors[mask_of(frame, "/World/Apple1")] == FRUIT["Apple"]["color"]).all()
    assert (colors[mask_of(frame, "/World/Pear")] == pear).all()
    assert (colors[mask_of(frame, "/World/Ground")] == 0).all()


def test_coco_s_own_categories_and_other(frame, tmp_path):
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match="no category is called class:pear: it becomes 'other'"):
        data = read(write(tmp_path, frame))
    assert [(each["name"], each["id"], each["isthing"]) for each in data["categories"][:2]] == [
        ("person", 1, 1), ("bicycle", 2, 1),
    ]  # fmt: skip
    # All but what is behind objects and what has no label, whatever the pictures show.
    assert [each["id"] for each in data["categories"]] == sorted(set(range(1, 202)) - {66, 69, 183})
    assert [each["category_id"] for each in data["annotations"]] == [53, 53, 201]


def test_the_table_of_categories():
    table = Categories()
    every = [*table.all(), *table._no_class.values()]
    # Two numbers that are given to other names, and one that is moved behind those of merged stuff.
    assert sorted(each["id"] for each in every) == sorted(set(range(203)) - {66, 69, 183})
    assert table.of({"class": "Traffic Light"})["id"] == 10
    assert table.of({"class": "vehicle,bus"})["id"] == 6
    assert table.of({"class": "cell_phone"})["id"] == table.of({"class": "Cell Phone"})["id"] == 77
    assert table.color({"class": "BACKGROUND"}) == table.color({"class": "UNLABELLED"}) == [0, 0, 0]
    black = [each["name"] for each in table.all() if each["color"] == [0, 0, 0]]
    assert black == []


def test_an_object_that_is_called_background_has_a_category_that_is_listed(tmp_path):
    stage = new_stage()
    for column, label in enumerate(["background", "Unlabelled", "apple"]):
        add_cube(stage, f"/World/Cube{column}", label, translate=(2 * column - 2, 0, 0), scale=(0.4, 0.4, 0.4))
    seen = make_frame(stage, (64, 48), filters=["class:*;coco:*;stuff:*;thing:*"])
    folder = write(tmp_path, seen, dataset_id="set")
    data = read(folder)
    assert [each["category_id"] for each in data["annotations"]] == [201, 201, 53]
    colors = {each["id"]: each["color"] for each in data["categories"]}
    with Image.open(folder / "rp1/panoptic_World-Camera_set.0000.png") as image:
        pixels = np.asarray(image)
    for column, number in enumerate([201, 201, 53]):
        assert (pixels[mask_of(seen, f"/World/Cube{column}")] == colors[number]).all()
    table = {"background": {"name": "wall", "id": 3, "color": [1, 2, 3]}}
    (tmp_path / "own").mkdir()
    own = read(write(tmp_path / "own", seen, coco_categories=table))
    assert [each["category_id"] for each in own["annotations"]] == [3, 201, 201]


@pytest.mark.parametrize(
    ("categories", "message"),
    [
        ({"apple": {"id": 1}}, "coco_categories['apple']"),
        ({"apple": {"name": "apple", "id": "1"}}, "coco_categories['apple']"),
        ({"a": {"name": "a", "id": 1}, "b": {"name": "b", "id": 1}}, "'a' and 'b' have one id, 1"),
        ({"a": {"name": "a", "id": 1, "color": [1, 2]}}, "color of coco_categories['a'] is [1, 2]"),
    ],
)
def test_wrong_categories_are_refused_before_any_work(categories, message, tmp_path):
    with pytest.raises(WriterError) as caught:
        writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "coco"), "coco_categories": categories})
    assert message in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("taken", "number"), [(1, 201), (201, 202)])
def test_an_own_table_gets_an_other_as_in_replicator(taken, number):
    forget_warnings()
    table = Categories({"apple": {"name": "apple", "id": taken}})
    assert table.all() == [table.of({"class": "apple"})]
    with pytest.warns(UsdsdgWarning, match=f"called class:unknown: it becomes 'other', id {number}. Add") as told:
        found = [table.of({"class": "unknown"}) for _ in range(2)]
    assert found == [table.reserve] * 2
    assert len(told) == 1
    assert (table.reserve["name"], table.reserve["id"]) == ("other", number)
    assert table.color({"class": "unknown"}) == table.reserve["color"] != [0, 0, 0]
    assert table.color({"class": "BACKGROUND"}) == table.color({"class": "UNLABELLED"}) == [0, 0, 0]


def test_an_other_that_was_added_is_listed_where_an_object_has_it(frame, tmp_path):
    apples = {"Apple": FRUIT["Apple"]}
    data = read(write(tmp_path, [frame, frame], coco_categories=apples))
    assert [(each["name"], each["id"]) for each in data["categories"]] == [("apple", 7), ("other", 201)]
    assert [each["category_id"] for each in data["annotations"]] == [7, 7, 201] * 2
    assert apples == {"Apple": FRUIT["Apple"]}


def test_labels_that_an_own_table_lacks_become_its_other():
    table = Categories({"apple": {"name": "apple", "id": 1}, "other": {"name": "rest", "id": 2}})
    assert table.of({"class": "unknown"})["name"] == "rest"


@pytest.mark.parametrize("number", [0, 1, 2, 201])
def test_a_category_without_a_color_is_not_black(number):
    (category,) = Categories({"apple": {"name": "apple", "id": number}}).all()
    assert max(category["color"]) > 100


def test_two_splits_with_other_objects_have_one_table_of_categories(tmp_path):
    tables = []
    for name in ("Apple", "pear"):
        stage = new_stage()
        add_cube(stage, "/World/Thing", name)
        frame = make_frame(stage, (32, 24), filters=["class:*;coco:*;stuff:*;thing:*"])
        tables.append(read(write(tmp_path / name, frame, coco_categories=FRUIT))["categories"])
    assert tables[0] == tables[1]
    assert [each["id"] for each in tables[0]] == [3, 7]


def test_pictures_without_objects_are_listed(tmp_path):
    data = read(write(tmp_path, make_frame(new_stage(), (8, 6))))
    assert (len(data["images"]), data["annotations"]) == (1, [])


def test_a_run_without_a_frame_leaves_no_file(tmp_path):
    writer = writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "coco")})
    writer.attach(known(PRODUCT))
    writer.on_final_frame()
    writer.detach()
    assert not list((tmp_path / "coco").iterdir())


def test_an_existing_folder_is_left_alone(frame, tmp_path):
    first = write(tmp_path, frame, coco_categories=FRUIT)
    before = {path: path.read_bytes() for path in first.rglob("*") if path.is_file()}
    second = write(tmp_path, frame, coco_categories=FRUIT)
    assert (first.name, second.name) == ("coco", "coco_0001")
    assert {path: path.read_bytes() for path in first.rglob("*") if path.is_file()} == before


def test_several_products_share_the_file(frame, tmp_path):
    two = {f"/Render/HydraTextures/{name}": dataclasses.replace(frame, memo={}) for name in ("left", "right")}
    folder = write(tmp_path, [two, two], coco_categories=FRUIT, dataset_id="d")
    names = [image["file_name"] for image in read(folder)["images"]]
    assert names == [f"{side}/rgb_World-Camera_d.{n:04d}.png" for n in (0, 1) for side in ("left", "right")]
    assert len(read(folder)["annotations"]) == 4 * len(SEEN)


def test_the_file_is_written_at_the_end_and_its_labels_are_in_the_spool_before(frame, tmp_path):
    writer = writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "coco"), "coco_categories": FRUIT})
    writer.attach(known(PRODUCT))
    records = tmp_path / "coco/.usdsdg/aggregates/CocoWriter/coco.jsonl"
    for number in range(30):
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        assert spool.read(records).count == number + 1
    writer.backend.wait_until_done()
    assert not list((tmp_path / "coco").glob("coco_annotations_*.json"))
    writer.on_final_frame()
    writer.backend.wait_until_done()
    data, found = read(tmp_path / "coco"), spool.read(records)
    assert all((tmp_path / "coco" / image["file_name"]).is_file() for image in data["images"])
    assert data["images"] == [each["image"] for each in found]
    rows = [row for each in found for row in each["instances"]]
    assert data["annotations"] == [{"id": number} | row for number, row in enumerate(rows, 1)]
    assert data["categories"] == found.about["splits"]["train"]["instances"]["categories"]


def test_the_id_follows_the_seed(frame, tmp_path):
    names = []
    for number, seed in enumerate((5, 5, 6)):
        writers.set_global_seed(seed)
        folder = write(tmp_path / str(number), frame, coco_categories=FRUIT)
        names.append(next(folder.glob("*.json")).stem.removeprefix("coco_annotations_"))
    writers.set_global_seed(None)
    assert names[0] == names[1] != names[2]
    assert all(len(name) == 8 and name.isalpha() for name in names)


def test_an_on_time_trigger_begins_a_sequence_of_its_own(frame, tmp_path):
    options = {"output_dir": str(tmp_path / "coco"), "coco_categories": FRUIT, "dataset_id": "d"}
    writer = writers.get("CocoWriter", init_params=options)
    writer.attach(known(PRODUCT))
    for fired in (1, 1, 2):
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}, trigger_outputs={"on_time": fired}))
    writer.detach()
    writer.backend.wait_until_done()
    names = [image["file_name"].partition("_d.")[2] for image in read(tmp_path / "coco")["images"]]
    assert names == ["1__0000.png", "1__0001.png", "2__0000.png"]


def test_jpegs_keep_the_pictures_of_categories_exact(frame, tmp_path):
    folder = write(tmp_path, frame, coco_categories=FRUIT, image_output_format="jpg")
    assert sorted(path.suffix for path in (folder / "rp1").iterdir()) == [".jpg", ".png"]


INTERRUPTED = """
from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, writers
writer = writers.get("CocoWriter", init_params={"output_dir": OUT, "dataset_id": "d"})
writer.attach(known("/Render/HydraTextures/rp1"))
frame = make_frame(street(), (16, 12))
for _ in range(7):
    writer.receive(annotators.build_payload(writer, {"/Render/HydraTextures/rp1": frame}))
raise KeyboardInterrupt
"""


def test_an_interrupted_program_leaves_a_whole_dataset(tmp_path):
    script = f"OUT = {str(tmp_path / 'coco')!r}\n{INTERRUPTED}"
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert "KeyboardInterrupt" in done.stderr
    data = read(tmp_path / "coco")
    assert len(data["images"]) == 7
    assert len(data["annotations"]) == 7 * len(SEEN)
    assert all((tmp_path / "coco" / image["file_name"]).is_file() for image in data["images"])


def test_a_thing_of_several_gprims_is_one_object(tmp_path):
    stage = new_stage()
    car = add_cube(stage, "/World/Car", "car", translate=(-1, 0, 0))
    add_cube(stage, f"{car.GetPath()}/Roof", translate=(1.5, 0, 0))
    frame = make_frame(stage, (64, 48))
    (record,) = read(write(tmp_path, frame))["annotations"]
    whole = mask_of(frame, "/World/Car") | mask_of(frame, "/World/Car/Roof")
    np.testing.assert_array_equal(decoded(record["segmentation"]["counts"], whole.shape), whole)


def test_options_of_basic_writer_are_taken_and_those_that_change_nothing_are_told(frame, tmp_path):
    forget_warnings()
    usual = {"rgb": True, "bounding_box_2d_tight": True, "semantic_segmentation": 1}
    write(tmp_path, frame, **usual, colorize_semantic_segmentation=False, colorize_instance_segmentation=True)
    with pytest.warns(UsdsdgWarning, match="CocoWriter: rgb=False has no effect"):
        writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "b"), "rgb": False})
    others = {"normals": False, "camera_params": None, "use_common_output_dir": True}
    with pytest.warns(UsdsdgWarning, match="CocoWriter: use_common_output_dir=True has no effect") as told:
        writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "c"), **others})
    assert len(told) == 1


def test_every_option_of_basic_writer_is_taken(tmp_path):
    names = set(inspect.signature(writers.get("BasicWriter").__init__).parameters)
    taken = set(inspect.signature(writers.get("CocoWriter").__init__).parameters)
    beyond_replicator = {
        "amodal_instance_segmentation", "visibility", "truncation", "bounding_box_2d_amodal", "object_coordinates",
        "oriented_bounding_box_2d", "oriented_bounding_box_2d_amodal", "dense_correspondence",
    }  # fmt: skip
    assert names - taken == {"backend"} | beyond_replicator
    with pytest.raises(WriterError, match="CocoWriter has no option 'use_comon_output_dir'"):
        writers.get("CocoWriter", init_params={"output_dir": str(tmp_path), "use_comon_output_dir": True})
