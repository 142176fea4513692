"""CocoWriter beyond Replicator's: plain names, splits, polygons, keypoints, segments, limits."""

import json

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import mask_of, street
from tests.dataset_files import data_names
from tests.writers.formats.shapes.test_polygons import filled
from tests.writers.formats.shapes.test_run_length import decoded
from usdsdg import annotators, writers
from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.writers.formats.coco.files import PlainNames, ReplicatorNames, names_of

PRODUCT, FILTER = "/Render/HydraTextures/rp1", "class:*;coco:*;stuff:*;thing:*"
SEEN = ["/World/Apple1", "/World/Apple2", "/World/Pear"]
CATEGORIES = {
    "apple": {"name": "apple", "id": 7},
    "pear": {"name": "pear", "id": 3, "isthing": 0},
    "plum": {"name": "plum", "id": 300, "isthing": 0},
}


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48), filters=[FILTER])


@pytest.fixture(autouse=True)
def _classes_of_the_frame(frame):
    """The frame is shared by the tests, the class table is not."""
    current().class_tables.of(FILTER).add(frame.selection(FILTER).labels)


def write(folder, frames, **options):
    """Write frames, one each time; return the folder."""
    writer = writers.get("CocoWriter", init_params={"output_dir": str(folder), "plain_names": True, **options})
    writer.attach(known(PRODUCT))
    for each in frames:
        writer.receive(annotators.build_payload(writer, {PRODUCT: each}))
    writer.detach()
    writer.backend.wait_until_done()
    return folder


def read(folder, split="train", kind="instances"):
    return json.loads((folder / f"annotations/{kind}_{split}.json").read_text())


def test_names_of_files_and_splits(frame, tmp_path):
    folder = write(tmp_path, [frame] * 4, splits={"train": 3, "val": 1}, panoptic=True, plain_names=None)
    pictures = [f"train/{number:04d}.png" for number in (0, 1, 3)] + ["val/0002.png"]
    segments = [f"annotations/panoptic_{name}" for name in pictures]
    tables = [f"annotations/{kind}_{split}.json" for kind in ("instances", "panoptic") for split in ("train", "val")]
    assert data_names(folder) == sorted([*pictures, *segments, *tables, "metadata.txt"])
    train, val = read(folder), read(folder, "val")
    assert [each["file_name"] for each in train["images"]] == ["0000.png", "0001.png", "0003.png"]
    assert [each["id"] for each in (*train["images"], *val["images"])] == [0, 1, 3, 2], "unique among the splits"
    numbers = [each["id"] for each in (*train["annotations"], *val["annotations"])]
    assert len(set(numbers)) == len(numbers) == 4 * len(SEEN)
    assert train["categories"] == val["categories"]


def test_a_name_of_a_file_tells_the_others():
    plain, own = names_of("out/annotations/instances_val.json"), names_of("coco_annotations_abc.json")
    assert plain == PlainNames("val", "out/")
    assert own == ReplicatorNames("abc")
    assert plain is not None
    assert own is not None
    assert plain.image("0001.jpg").picture == "out/val/0001.jpg"
    assert plain.image("0001.jpg").panoptic == "out/annotations/panoptic_val/0001.png"
    assert own.image("rp/rgb_cam_abc.0001.jpg").classes == "rp/panoptic_cam_abc.0001.png"
    assert names_of("annotations/panoptic_val.json") is None
    assert names_of("classes.json") is None


def test_a_folder_is_used_again(frame, tmp_path):
    write(tmp_path, [frame, frame])
    write(tmp_path, [frame])
    assert len(read(tmp_path)["images"]) == 1


def test_categories_are_the_classes_of_the_dataset_seen_or_not(frame, tmp_path):
    table = current().class_tables.of(FILTER)
    table.add([{"class": "never"}])
    data = read(write(tmp_path, [frame]))
    assert {each["name"]: each["id"] for each in data["categories"]} == {
        row["name"]: row["id"] for row in table.listed()
    }
    assert "never" in {each["name"] for each in data["categories"]}
    by_id = {each["id"]: each["name"] for each in data["categories"]}
    assert [by_id[each["category_id"]] for each in data["annotations"]] == ["apple", "apple", "pear"]


@pytest.mark.parametrize("plain_names", [True, False])
def test_a_predicate_chooses_labels(frame, plain_names, tmp_path):
    options = {"semantic_filter_predicate": "class:pear", "plain_names": plain_names, "dataset_id": "0"}
    categories = {name: {"name": name, "id": number} for number, name in enumerate(("apple", "pear"), 1)}
    chosen = make_frame(street(), (64, 48), filters=["class:pear"])
    folder = write(tmp_path / "out", [chosen], coco_categories=categories, **options)
    file = folder / ("annotations/instances_train.json" if plain_names else "coco_annotations_0.json")
    data = json.loads(file.read_text())
    assert [each["category_id"] for each in data["annotations"]] == [2]
    (found,) = data["annotations"]
    mask = mask_of(frame, "/World/Pear")
    assert (decoded(found["segmentation"]["counts"], mask.shape) == mask).all()
    with pytest.raises(WriterError, match="exclude each other"):
        write(tmp_path / "both", [chosen], semantic_types=["class"], **options)


def test_polygons_are_outlines_along_the_edges_of_pixels(frame, tmp_path):
    masks = read(write(tmp_path / "rle", [frame]))["annotations"]
    shapes = read(write(tmp_path / "polygon", [frame], segmentation="polygon"))["annotations"]
    for path, exact, shape in zip(SEEN, masks, shapes, strict=True):
        mask = mask_of(frame, path)
        assert (decoded(exact["segmentation"]["counts"], mask.shape) == mask).all()
        inside = sum(filled(np.array(each).reshape(-1, 2), mask.shape) for each in shape["segmentation"])
        assert (inside == mask).all()
        assert {key: exact[key] for key in ("bbox", "area", "id")} == {
            key: shape[key] for key in ("bbox", "area", "id")
        }


def test_segments_are_those_of_the_picture(frame, tmp_path):
    folder = write(tmp_path, [frame], panoptic=True, coco_categories=CATEGORIES)
    data = read(folder, kind="panoptic")
    (record,) = data["annotations"]
    channels = np.asarray(Image.open(folder / "annotations/panoptic_train" / record["file_name"])).astype(int)
    ids = channels @ (1, 256, 256**2)
    named = {each["id"]: each for each in record["segments_info"]}
    assert set(np.unique(ids)) == {0, *named}
    for path in SEEN:
        mask = mask_of(frame, path)
        (number,) = np.unique(ids[mask])
        rows, columns = np.nonzero(ids == number)
        each = named[number]
        assert each["area"] == len(rows)
        assert each["bbox"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
        assert each["iscrowd"] == 0
        assert each["category_id"] == (3 if path.endswith("Pear") else 7)
    assert not ids[~np.any([mask_of(frame, path) for path in SEEN], axis=0)].any()
    # Stuff is in the panoptic form only, as in COCO, whether or not it is seen.
    assert {each["id"] for each in data["categories"]} == {3, 7, 300}
    assert {each["id"] for each in read(folder)["categories"]} == {7}
    assert {each["category_id"] for each in read(folder)["annotations"]} == {7}


def test_stuff_of_one_category_is_one_segment(frame, tmp_path):
    stuff = {name: {**each, "isthing": 0} for name, each in CATEGORIES.items()}
    folder = write(tmp_path, [frame], panoptic=True, coco_categories=stuff)
    (record,) = read(folder, kind="panoptic")["annotations"]
    apples = [each for each in record["segments_info"] if each["category_id"] == 7]
    assert len(apples) == 1
    assert apples[0]["area"] == sum(mask_of(frame, path).sum() for path in SEEN[:2])
    assert read(folder)["annotations"] == []


def test_what_is_hardly_visible_is_left_out(frame, tmp_path):
    sizes = [mask_of(frame, path).sum() for path in SEEN]
    folder = write(tmp_path, [frame], min_pixels=int(min(sizes)) + 1, panoptic=True)
    assert [each["area"] for each in read(folder)["annotations"]] == [size for size in sizes if size > min(sizes)]
    (record,) = read(folder, kind="panoptic")["annotations"]
    assert len(record["segments_info"]) == sum(size > min(sizes) for size in sizes)


def test_info_and_licenses(frame, tmp_path):
    licenses = [{"id": 4, "name": "CC0", "url": ""}]
    data = read(write(tmp_path, [frame], coco_info={"description": "Fruit", "year": 2026}, coco_license_info=licenses))
    assert (data["info"]["description"], data["info"]["year"], data["licenses"]) == ("Fruit", 2026, licenses)
    assert data["images"][0]["license"] == 4


def posed(tmp_path, **options):
    """Write a cube with keypoints, one inside of it and one out of the picture; return the file's values."""
    create = rep.functional.create
    cube = create.cube(position=(0, 0, 0), scale=1.0, rotation=(0, 0, 0), semantics={"class": "cube"})
    rep.functional.modify.keypoints(cube, {"front": (0, -0.5, 0), "back": (0, 0.5, 0), "far": (50, 0, 0)})
    create.cube(position=(2, 0, 0), scale=0.5, semantics={"class": "plain"})
    hidden = create.cube(semantics={"class": "later"})
    rep.functional.modify.keypoints(hidden, {"top": (0, 0, 1)})
    rep.functional.modify.visibility(hidden, False)
    camera = create.camera(position=(1, -8, 0), look_at=(1, 0, 0))
    writer = rep.WriterRegistry.get("CocoWriter")
    writer.initialize(output_dir=str(tmp_path), plain_names=True, **options)
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return writer, read(tmp_path)


def test_keypoints_of_the_stage(stage, tmp_path):
    _, data = posed(tmp_path, keypoints=True)
    named = {each["name"]: each for each in data["categories"]}
    assert named["cube"]["keypoints"] == ["back", "far", "front"]
    assert (named["later"]["keypoints"], "keypoints" in named["plain"]) == (["top"], False)
    assert data["info"]["keypoint_sigmas"] == {"cube": [0.05] * 3, "later": [0.05]}
    cube, plain = data["annotations"]
    points = np.array(cube["keypoints"]).reshape(3, 3)
    assert points[:, 2].tolist() == [1, 0, 2]
    assert points[1].tolist() == [0, 0, 0]
    assert cube["num_keypoints"] == 2
    assert "keypoints" not in plain
    # A pinhole of 24 mm over 20.955 mm, 7.5 m before the face of the cube, one meter beside it.
    focal = 64 * 24 / 20.955
    assert points[2, :2] == pytest.approx((32 - focal / 7.5, 24), abs=2e-3)
    assert points[0, :2] == pytest.approx((32 - focal / 8.5, 24), abs=2e-3)


def test_keypoints_of_the_stage_under_a_filter_in_upper_case(stage, tmp_path):
    _, data = posed(tmp_path, keypoints=True, semantic_filter_predicate="class: Cube | LATER")
    named = {each["name"]: each.get("keypoints") for each in data["categories"]}
    assert named == {"cube": ["back", "far", "front"], "later": ["top"]}


def test_keypoints_with_a_skeleton(stage, tmp_path):
    given = {"Cube": {"keypoints": ["front", "far", "back"], "skeleton": [("front", "back")], "sigmas": [1, 2, 3]}}
    writer, data = posed(tmp_path, keypoints=given)
    cube = next(each for each in data["categories"] if each["name"] == "cube")
    assert (cube["keypoints"], cube["skeleton"]) == (["front", "far", "back"], [[1, 3]])
    assert data["annotations"][0]["keypoints"][2::3] == [2, 0, 1]
    assert data["info"]["keypoint_sigmas"]["cube"] == [1, 2, 3]
    another = rep.functional.create.cube(position=(0, 0, 1.5), semantics={"class": "cube"})
    rep.functional.modify.keypoints(another, {"top": (0, 0, 1)})
    with pytest.raises(WriterError, match="keypoints top of cube are new"):
        rep.orchestrator.step()
    writer.detach()


@pytest.mark.filterwarnings("ignore:.* is not among semantic_classes")
def test_keypoints_of_a_class_that_a_later_frame_brings(stage, tmp_path):
    rep.settings.set_semantic_classes(["cube", "late"])
    writer, _ = posed(tmp_path, keypoints={"cube": ["front", "far", "back"], "late": ["top"]})
    late = rep.functional.create.cube(position=(0, 0, 1.5), semantics={"class": "late"})
    rep.functional.modify.keypoints(late, {"top": (0, 0, 0.5)})
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    named = {each["name"]: each for each in read(tmp_path)["categories"]}
    assert (named["late"]["keypoints"], named["cube"]["keypoints"]) == (["top"], ["front", "far", "back"])
    brought = rep.functional.create.cube(position=(0, 0, -1.5), semantics={"class": "brought"})
    rep.functional.modify.keypoints(brought, {"top": (0, 0, 0.5)})
    with pytest.raises(
        WriterError, match=r"of brought are new.* If the class is new, too, list it in semantic_classes"
    ):
        rep.orchestrator.step()
    writer.detach()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"segmentation": "mask"}, "expected one of rle, polygon"),
        ({"splits": {"train": 1}, "plain_names": False}, "splits need plain_names"),
        ({"min_visibility": -1.0}, "expected a fraction"),
        ({"keypoints": {"cube": []}}, "expected a list of names"),
        ({"keypoints": {"cube": ["a", "a"]}}, "names a keypoint twice"),
        ({"keypoints": {"cube": {"names": ["a"]}}}, "expected keypoints, skeleton and sigmas"),
        ({"keypoints": {"cube": {"keypoints": ["a"], "skeleton": [["a", "b"]]}}}, "expected pairs of its keypoints, a"),
        ({"keypoints": {"cube": {"keypoints": ["a"], "sigmas": [0]}}}, "expected 1 number above 0"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        writers.get("CocoWriter", init_params={"output_dir": str(tmp_path / "coco"), **options})


def test_keypoints_of_what_is_no_category(stage, tmp_path):
    listed = r"given for 'dog', which is no category; there are cube, later, plain\. List .* in semantic_classes"
    with pytest.raises(WriterError, match=listed):
        posed(tmp_path, keypoints={"dog": ["tail"]})
