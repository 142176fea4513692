"""YoloWriter: its lines against the masks of the frame, and its files against what trainers expect."""

import json

import numpy as np
import pytest
import yaml
from PIL import Image

import usdsdg as rep
from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import mask_of
from tests.dataset_files import data_names
from tests.writers.formats.shapes.test_polygons import filled
from usdsdg import annotators, writers
from usdsdg.errors import UsdsdgWarning, WriterError
from usdsdg.session.session import current
from usdsdg.verify import verify
from usdsdg.writers.formats.splits import Splits

PRODUCT = "/Render/HydraTextures/rp1"


pytestmark = pytest.mark.usefixtures("classes_of_the_frame")


def write(folder, frames, kind="YoloWriter", **options):
    """Write frames ({path: frame} or one each time); return the folder."""
    writer = writers.get(kind, init_params={"output_dir": str(folder), **options})
    sets = [each if isinstance(each, dict) else {PRODUCT: each} for each in frames]
    writer.attach(known(*sets[0]))
    for each in sets:
        writer.receive(annotators.build_payload(writer, each))
    writer.detach()
    writer.backend.wait_until_done()
    return folder


def lines(file):
    """Return class and numbers of each line."""
    rows = [line.split() for line in file.read_text().splitlines()]
    return [(int(row[0]), np.array(row[1:], float)) for row in rows]


def members_of(frame):
    """Return which labeled object each pixel shows, as its index in the order of the stage; -1 for none."""
    return np.append(frame.selection("class:*").member_of_gprim, -1)[frame.aovs["instance"]]


def labeled_in_view(frame):
    """Return the label and mask of each labeled object in view, in the order of the stage."""
    members, selected = members_of(frame), frame.selection("class:*").labels
    labels = [(each["class"], members == index) for index, each in enumerate(selected)]
    return [(label, mask) for label, mask in labels if mask.any()]


def visible(frame):
    """Return the names of all classes, and of each labeled object in view the place of its class and its mask."""
    names = sorted({labels["class"] for labels in frame.selection("class:*").labels})
    return names, [(names.index(label), mask) for label, mask in labeled_in_view(frame)]


def test_boxes_are_the_extents_of_masks(frame, tmp_path):
    folder = write(tmp_path, [frame])
    names, expected = visible(frame)
    found = lines(folder / "labels/train/000000.txt")
    assert [number for number, _ in found] == [number for number, _ in expected]
    assert len(expected) > 2
    for (_, box), (_, mask) in zip(found, expected):
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        x, y, width, height = box * (64, 48, 64, 48)
        assert np.allclose((x - width / 2, x + width / 2), (columns[0], columns[-1] + 1), atol=1e-3)
        assert np.allclose((y - height / 2, y + height / 2), (rows[0], rows[-1] + 1), atol=1e-3)
    described = yaml.safe_load((folder / "data.yaml").read_text())
    assert list(described["names"].values()) == names
    assert list(described["names"]) == list(range(len(names)))
    assert (described["train"], described["val"]) == ("images/train", "images/train")
    assert np.array_equal(np.array(Image.open(folder / "images/train/000000.png")), frame.aovs["LdrColor"][..., :3])


def test_outlines_are_those_of_masks(frame, tmp_path):
    folder = write(tmp_path, [frame], task="segment")
    _, expected = visible(frame)
    for (number, corners), (wanted, mask) in zip(lines(folder / "labels/train/000000.txt"), expected, strict=True):
        polygon = corners.reshape(-1, 2) * (64, 48)
        assert number == wanted
        assert np.allclose(polygon, np.round(polygon), atol=1e-3)
        again = filled(np.round(polygon), mask.shape)
        assert (again & mask).sum() == mask.sum()  # only holes are lost
    assert mask_of(frame, "/World/Apple1").any()


def test_names_of_files_and_parts(frame, tmp_path):
    folder = write(tmp_path, [frame] * 10, splits={"train": 0.6, "val": 0.2, "test": 0.2}, frame_padding=3)
    names = data_names(folder)
    for split, count in (("train", 6), ("val", 2), ("test", 2)):
        stems = [name.split("/")[2][:-4] for name in names if name.startswith(f"images/{split}/")]
        assert len(stems) == count
        assert [f"labels/{split}/{stem}.txt" in names for stem in stems] == [True] * count
    assert len(names) == 10 * 2 + 2  # and data.yaml, metadata.txt
    described = yaml.safe_load((folder / "data.yaml").read_text())
    assert {each: described[each] for each in ("train", "val", "test")} == {
        each: f"images/{each}" for each in ("train", "val", "test")
    }


def test_products_have_files_of_their_own(frame, tmp_path):
    folder = write(tmp_path, [{PRODUCT: frame, f"{PRODUCT}2": frame}])
    assert (folder / "labels/train/rp1_000000.txt").read_text() == (folder / "labels/train/rp12_000000.txt").read_text()


def test_what_is_hardly_visible_or_small_is_left_out(frame, tmp_path):
    _, expected = visible(frame)
    hidden = frame.occlusion("class:*")[np.flatnonzero(frame.visible_pixels("class:*") > 0)]
    pixels = [mask.sum() for _, mask in expected]
    whole = sum(1.0 - ratio >= 0.999 for ratio in hidden)
    assert 0 < whole < len(expected)
    folder = write(tmp_path / "visible", [frame], min_visibility=0.999)
    assert len(lines(folder / "labels/train/000000.txt")) == whole
    least = int(np.median(pixels)) + 1
    folder = write(tmp_path / "large", [frame], min_pixels=least)
    assert len(lines(folder / "labels/train/000000.txt")) == sum(count >= least for count in pixels)


def test_an_empty_picture_has_an_empty_file(tmp_path):
    from tests.annotators.ray_caster import new_stage

    folder = write(tmp_path, [make_frame(new_stage(), (16, 12), filters=["class:*"])])
    assert (folder / "labels/train/000000.txt").read_text() == ""


def test_a_dataset_without_a_class_has_its_description(tmp_path):
    """As pictures of backgrounds have no other file that says where they are."""
    from tests.annotators.ray_caster import new_stage

    current().class_tables.reset()
    write(tmp_path, [make_frame(new_stage(), (16, 12), filters=["class:*"])])
    described = yaml.safe_load((tmp_path / "data.yaml").read_text())
    assert described == {"train": "images/train", "val": "images/train", "names": {}}


def test_classes_are_those_of_the_table(stage, tmp_path):
    rep.settings.set_semantic_classes({"pear": 9, "apple": 4, "plum": 30})
    for x, name in enumerate(("pear", "plum")):
        rep.functional.create.cube(position=(x, 0, 0), scale=0.4, semantics={"class": name})
    camera = rep.functional.create.camera(position=(0.5, -5, 0), look_at=(0.5, 0, 0))
    writer = rep.WriterRegistry.get("YoloWriter")
    writer.initialize(output_dir=str(tmp_path))
    writer.attach(rep.create.render_product(camera, (64, 48)))
    rep.orchestrator.step()
    rep.functional.create.cube(position=(0, 0, 1), scale=0.4, semantics={"class": "fig"})
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert yaml.safe_load((tmp_path / "data.yaml").read_text())["names"] == {0: "apple", 1: "pear", 2: "plum", 3: "fig"}
    assert [number for number, _ in lines(tmp_path / "labels/train/000000.txt")] == [1, 2]
    assert [number for number, _ in lines(tmp_path / "labels/train/000001.txt")] == [1, 2, 3]


def posed(tmp_path, **options):
    """Write a cube with keypoints, half of it hidden by another; return the lines and data.yaml."""
    create = rep.functional.create
    cube = create.cube(position=(0, 0, 0), scale=1.0, rotation=(0, 0, 0), semantics={"class": "cube"})
    names = {"front": (0, -0.5, 0), "back": (0, 0.5, 0), "far": (50, 0, 0)}
    rep.functional.modify.keypoints(cube, names)
    create.cube(position=(2, 0, 0), scale=0.5, rotation=(0, 45, 0), semantics={"class": "plain"})
    camera = create.camera(position=(1, -8, 0), look_at=(1, 0, 0))
    writer = rep.WriterRegistry.get("YoloWriter")
    writer.initialize(output_dir=str(tmp_path), **options)
    product = rep.create.render_product(camera, (64, 48))
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    described = yaml.safe_load((tmp_path / "data.yaml").read_text())
    return lines(tmp_path / "labels/train/000000.txt"), described, writer


def test_keypoints_are_in_the_order_of_their_names(stage, tmp_path):
    (cube, plain), described, _ = posed(tmp_path, task="pose")
    assert described["kpt_shape"] == [3, 3]
    box, points = cube[1][:4], cube[1][4:].reshape(3, 3)  # back, far, front
    assert points[:, 2].tolist() == [1, 0, 2]
    assert points[1].tolist() == [0, 0, 0]
    # Both are on the line of sight to the box's center, up to perspective.
    assert np.abs(points[2, :2] - box[:2]).max() < 0.03
    assert plain[1][4:].tolist() == [0] * 9


@pytest.mark.parametrize("far", [False, True])
def test_of_keypoints_of_one_name_in_one_object_the_last_in_the_picture_is_written(stage, tmp_path, far):
    create, modify = rep.functional.create, rep.functional.modify
    body = create.xform(name="body", semantics={"class": "body"})
    for index in range(2):
        part = create.cube(parent=body, name=f"part{index}", position=(index, 0, 0), scale=0.5)
        modify.keypoints(part, {"tip": (90 if far and index else 0, -0.5, 0)})
    product = rep.create.render_product(create.camera(position=(0, -8, 0), look_at=(0, 0, 0)), (64, 48))
    places = []
    for name, options in (("YoloWriter", {"task": "pose"}), ("CocoWriter", {"plain_names": True, "keypoints": True})):
        writer = rep.writers.get(name)
        writer.initialize(output_dir=str(tmp_path / name), **options)
        writer.attach(product)
    with pytest.warns(UsdsdgWarning, match="body/part0 and .*body/part1 are parts of one object .* of one name, tip"):
        rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    (line,) = (tmp_path / "YoloWriter/labels/train/000000.txt").read_text().splitlines()
    places.append(float(line.split()[5]) * 64)
    (thing,) = json.loads((tmp_path / "CocoWriter/annotations/instances_train.json").read_text())["annotations"]
    places.append(thing["keypoints"][0])
    expected = 32 + (0 if far else 1) * 64 * 24 / 20.955 / 7.75
    assert places == pytest.approx([expected] * 2, abs=2e-3)
    assert verify(tmp_path / "CocoWriter").faults == []


def test_keypoints_that_come_later_are_an_error(stage, tmp_path):
    _, _, writer = posed(tmp_path, task="pose", keypoints=["front", "back", "far"])
    found = lines(tmp_path / "labels/train/000000.txt")[0][1][4:].reshape(3, 3)
    assert found[:, 2].tolist() == [2, 1, 0]
    rep.functional.modify.keypoints(rep.functional.create.cube(semantics={"class": "cube"}), {"top": (0, 0, 1)})
    with pytest.raises(WriterError, match="keypoints top are new"):
        rep.orchestrator.step()
    writer.detach()


def test_oriented_boxes_enclose_masks(stage, tmp_path):
    (cube, plain), _, _ = posed(tmp_path, task="obb")
    for number, corners in ((0, cube[1]), (1, plain[1])):
        polygon = corners.reshape(4, 2) * (64, 48)
        sides = np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1)
        assert np.allclose(sides[:2], sides[2:], atol=1e-2)
        assert number in (cube[0], plain[0])
    turned = plain[1].reshape(4, 2) * (64, 48)
    assert np.ptp(turned[:, 0]) > 1.2 * np.linalg.norm(turned[0] - turned[1])  # by 45 degrees


def test_an_oriented_box_across_the_picture_is_no_larger_than_it(stage, tmp_path):
    create = rep.functional.create
    create.cube(position=(0, 0, 0), scale=(20, 0.6, 0.1), rotation=(0, 0, 45), semantics={"class": "bar"})
    writer = rep.WriterRegistry.get("YoloWriter")
    writer.initialize(output_dir=str(tmp_path), task="obb")
    camera = create.camera(position=(0, 0, 5), look_at=(0, 0.0001, 0))
    writer.attach(rep.create.render_product(camera, (96, 96)))
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    ((_, corners),) = lines(tmp_path / "labels/train/000000.txt")
    polygon = corners.reshape(4, 2)
    # Ultralytics' `verify_image_label` refuses a picture where these are above 1.01.
    assert np.ptp(polygon, axis=0).max() <= 1.0
    assert np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1).max() > 1.2  # still along the diagonal
    assert not verify(tmp_path).faults


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"task": "track"}, "expected one of detect, segment, obb, pose"),
        ({"min_visibility": 2.0}, "expected a fraction"),
        ({"splits": {"train": 0}}, "expected shares above 0"),
        ({"splits": {}}, "expected shares above 0"),
        ({"semantic_types": ["class"], "semantic_filter_predicate": "class:*"}, "exclude each other"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        writers.get("YoloWriter", init_params={"output_dir": str(tmp_path), **options})


def test_every_beginning_of_a_run_has_the_shares():
    splits = Splits("x", {"train": 7, "val": 2, "test": 1})
    dealt = [splits.of(frame) for frame in range(200)]
    for count in range(10, 201, 10):
        assert [dealt[:count].count(name) for name in splits.names] == [count * 7 // 10, count // 5, count // 10]
    assert Splits("x", {"train": 7, "val": 2, "test": 1}).of(57) == dealt[57]
    together = Splits("x", {"train": 1, "val": 1}, 3)
    assert [together.of(frame) for frame in range(9)] == ["train"] * 3 + ["val"] * 3 + ["train"] * 3
