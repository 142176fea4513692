"""CvatWriter: its shapes against the masks of the frame, as CVAT's import reads them."""

import json
from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image, ImageDraw

import usdsdg as rep
from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.dataset_files import data_names
from tests.writers.formats.test_writer_yolo import PRODUCT, labeled_in_view
from tests.writers.formats.test_writer_yolo import write as written
from usdsdg import writers
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import cvat
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.session import current
from usdsdg.verify import verify
from usdsdg.writers.formats.cvat import cvat_xml

SIZE = (64, 48)
write = partial(written, kind="CvatWriter")


pytestmark = pytest.mark.usefixtures("classes_of_the_frame")


def images(folder):
    """Return the elements of the pictures."""
    return ElementTree.parse(folder / "annotations.xml").getroot().findall("image")


def shapes(folder, place=0):
    return list(images(folder)[place])


def decoded(shape, size=SIZE):
    """Return the pixels of a mask: runs outside and inside, in turn, along the rows of its rectangle."""
    left, top, width, height = (int(shape.get(name)) for name in ("left", "top", "width", "height"))
    lengths = [int(each) for each in shape.get("rle").split(", ")]
    inside = np.repeat(np.arange(len(lengths)) % 2 == 1, lengths).reshape(height, width)
    whole = np.zeros(size[::-1], bool)
    whole[top : top + height, left : left + width] = inside
    return whole


def test_masks_are_those_of_the_frame(frame, tmp_path):
    folder = write(tmp_path, [frame])
    expected = labeled_in_view(frame)
    assert len(expected) > 2
    for shape, (name, mask) in zip(shapes(folder), expected, strict=True):
        rows, columns = np.nonzero(mask)
        assert (shape.tag, shape.get("label")) == ("mask", name)
        assert [int(shape.get(side)) for side in ("left", "top", "width", "height")] == [
            columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1,
        ]  # fmt: skip
        np.testing.assert_array_equal(decoded(shape), mask)


@pytest.mark.parametrize("first", [True, False])
def test_runs_begin_outside(first):
    pixels = np.array([[first, True, False], [False, True, True]])
    shape = ElementTree.fromstring(cvat_xml.mask("x", pixels, (3, 5), instance=1, occluded=False))
    expected = np.zeros((10, 10), bool)
    expected[5:7, 3:6] = pixels
    np.testing.assert_array_equal(decoded(shape, (10, 10)), expected)
    assert shape.get("rle").startswith("0, 2, ") == first


def test_boxes_are_edges_of_pixels(frame, tmp_path):
    folder = write(tmp_path, [frame], shape="box")
    for shape, (name, mask) in zip(shapes(folder), labeled_in_view(frame), strict=True):
        rows, columns = np.nonzero(mask)
        assert (shape.tag, shape.get("label")) == ("box", name)
        assert [float(shape.get(side)) for side in ("xtl", "ytl", "xbr", "ybr")] == [
            columns.min(), rows.min(), columns.max() + 1, rows.max() + 1,
        ]  # fmt: skip


def test_what_fills_the_picture_reaches_its_edges(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/Wall", "wall", scale=(50, 50, 1))
    frame = make_frame(stage, (16, 12), filters=["class:*"])
    (box,) = shapes(write(tmp_path / "box", [frame], shape="box"))
    assert [box.get(side) for side in ("xtl", "ytl", "xbr", "ybr")] == ["0.00", "0.00", "16.00", "12.00"]
    (mask,) = shapes(write(tmp_path / "mask", [frame]))
    assert mask.get("rle") == f"0, {16 * 12}"


def test_polygons_are_outlines_and_parts_are_a_group(tmp_path):
    """A bar across a board leaves two pieces of it; a frame around a hole is filled."""
    stage = new_stage()
    add_cube(stage, "/World/Board", "board", scale=(2, 2, 0.1), translate=(-1.5, 0, 0))
    add_cube(stage, "/World/Bar", "bar", scale=(3, 0.5, 0.1), translate=(-1.5, 0, 1))
    add_cube(stage, "/World/Plate", "plate", scale=(2, 2, 0.1), translate=(2, 0, 0))
    add_cube(stage, "/World/Lid", scale=(0.6, 0.6, 0.1), translate=(2, 0, 0.2))
    frame = make_frame(stage, SIZE, filters=["class:*"])
    found = shapes(write(tmp_path, [frame], shape="polygon"))
    by_label = {name: [each for each in found if each.get("label") == name] for name in ("board", "bar", "plate")}
    assert {name: len(each) for name, each in by_label.items()} == {"board": 2, "bar": 1, "plate": 1}
    assert len({each.get("group_id") for each in by_label["board"]}) == 1
    assert int(by_label["board"][0].get("group_id")) > 0
    assert [each.get("group_id") for each in (*by_label["bar"], *by_label["plate"])] == [None, None]
    masks = dict(labeled_in_view(frame))
    rows, columns = np.nonzero(masks["plate"])
    assert masks["plate"].sum() < (np.ptp(rows) + 1) * (np.ptp(columns) + 1)  # it has a hole
    masks["plate"][rows.min() : rows.max() + 1, columns.min() : columns.max() + 1] = True
    for name, parts in by_label.items():
        whole = np.zeros((48, 64), bool)
        for each in parts:
            corners = [tuple(map(float, pair.split(","))) for pair in each.get("points").split(";")]
            # Four times larger, so that edges of pixels are whole numbers apart from their centers.
            drawn = Image.new("1", (256, 192))
            ImageDraw.Draw(drawn).polygon([(4 * x - 0.5, 4 * y - 0.5) for x, y in corners], fill=1)
            whole |= np.array(drawn)[2::4, 2::4]
        np.testing.assert_array_equal(whole, masks[name])
    path = tmp_path / "annotations.xml"
    path.write_text(path.read_text().replace(" group_id=", " group="))
    folder = Folder(tmp_path)
    assert list(cvat.read(folder, folder.files)) == []
    assert ["are not one group" in fault.what for fault in folder.faults] == [True]


def test_the_instance_is_that_of_instance_segmentation(frame, tmp_path):
    folder = write(tmp_path, [frame])
    found = [int(shape.findtext("attribute")) for shape in shapes(folder)]
    assert {attribute.get("name") for attribute in ElementTree.parse(folder / "annotations.xml").iter("attribute")} == {
        "instance", None,
    }  # fmt: skip
    selection, visible = frame.selection("class:*"), frame.visible_pixels("class:*") > 0
    assert found == selection.ids[visible].tolist()


def test_flags_and_what_is_left_out_follow_the_limits(frame, tmp_path):
    hidden = frame.occlusion("class:*")[np.flatnonzero(frame.visible_pixels("class:*") > 0)]
    assert 0 < hidden.max() < 1
    most = hidden == hidden.max()
    folder = write(tmp_path / "a", [frame], occluded_threshold=float(hidden.max()) - 1e-3)
    assert [shape.get("occluded") for shape in shapes(folder)] == most.astype(int).astype(str).tolist()
    folder = write(tmp_path / "b", [frame], occluded_threshold=float(hidden.max()) + 1e-3)
    assert {shape.get("occluded") for shape in shapes(folder)} == {"0"}
    folder = write(tmp_path / "c", [frame], min_visibility=float(1 - hidden.max()) + 1e-3)
    assert len(shapes(folder)) == (~most).sum()
    pixels = [int(mask.sum()) for _, mask in labeled_in_view(frame)]
    folder = write(tmp_path / "d", [frame], min_pixels=sorted(pixels)[1])
    assert len(shapes(folder)) == len(pixels) - 1


def test_the_task_has_pictures_and_labels(frame, tmp_path):
    folder = write(tmp_path, [frame] * 3)
    names = [f"{number:06d}.png" for number in range(3)]
    assert data_names(folder) == [
        "annotations.xml",
        *(f"images/{name}" for name in names),
        "labels.json",
        "metadata.txt",
    ]
    assert [(each.get("id"), each.get("name")) for each in images(folder)] == list(zip("012", names))
    assert {(each.get("width"), each.get("height")) for each in images(folder)} == {("64", "48")}
    root = ElementTree.parse(folder / "annotations.xml").getroot()
    assert (root.findtext("version"), root.findtext("meta/task/size")) == ("1.1", "3")
    labels = json.loads((folder / "labels.json").read_text())
    assert [each["name"] for each in labels] == [each.text for each in root.iterfind("meta/task/labels/label/name")]
    assert [each["color"] for each in labels] == [each.text for each in root.iterfind("meta/task/labels/label/color")]
    assert sorted(each["name"] for each in labels) == ["apple", "far", "pear", "secret"]
    assert all([own["name"] for own in each["attributes"]] == ["instance"] for each in labels)


def test_pictures_are_in_the_order_of_their_names(frame, tmp_path):
    folder = write(tmp_path, [{f"{PRODUCT}2": frame, PRODUCT: frame}] * 2)
    names = [each.get("name") for each in images(folder)]
    assert names == ["rp12_000000.png", "rp12_000001.png", "rp1_000000.png", "rp1_000001.png"]
    assert [each.get("id") for each in images(folder)] == ["0", "1", "2", "3"]


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("salt & 'pepper'", "salt & 'pepper'"), ('<a "quoted" mug>', '<a "quoted" mug>'), ("a:b/c#1", "a:b/c#1"),
        ("grüne tasse", "grüne tasse"), ("two\nlines", "two_lines"), ("bell\x07", "bell_"),
    ],
)  # fmt: skip
def test_names_of_classes_fit_xml(label, name, tmp_path):
    forget_warnings()
    stage = new_stage()
    add_cube(stage, "/World/Odd", label)
    frame = make_frame(stage, (16, 12), filters=["class:*"])
    if name == label:
        folder = write(tmp_path, [frame])
    else:
        with pytest.warns(UsdsdgWarning, match="since the format cannot have all of it"):
            folder = write(tmp_path, [frame])
    (shape,) = shapes(folder)
    assert shape.get("label") == name
    root = ElementTree.parse(folder / "annotations.xml").getroot()
    assert name in [each.text for each in root.iterfind("meta/task/labels/label/name")]
    assert name in [each["name"] for each in json.loads((folder / "labels.json").read_text())]


def test_two_classes_of_one_name_are_an_error(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/One", "a\x07b", translate=(-1, 0, 0))
    add_cube(stage, "/World/Two", "a_b", translate=(1, 0, 0))
    with pytest.raises(WriterError, match="several classes would be called a_b"):
        write(tmp_path, [make_frame(stage, (16, 12), filters=["class:*"])])
    assert not (tmp_path / "annotations.xml").exists()


def test_a_picture_without_objects_is_listed(tmp_path):
    current().class_tables.reset()
    folder = write(tmp_path, [make_frame(new_stage(), (16, 12), filters=["class:*"])])
    assert [len(each) for each in images(folder)] == [0]
    assert json.loads((folder / "labels.json").read_text()) == []


def test_classes_that_come_later_are_labels_of_the_task(stage, tmp_path):
    create = rep.functional.create
    create.cube(scale=0.4, semantics={"class": "pear"})
    writer = rep.WriterRegistry.get("CvatWriter")
    writer.initialize(output_dir=str(tmp_path))
    writer.attach(rep.create.render_product(create.camera(position=(0, -5, 0), look_at=(0, 0, 0)), SIZE))
    rep.orchestrator.step()
    create.cube(position=(0, 0, 1), scale=0.4, semantics={"class": "fig"})
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert [each["name"] for each in json.loads((tmp_path / "labels.json").read_text())] == ["pear", "fig"]
    assert verify(tmp_path).faults == []


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"shape": "cuboid"}, "expected one of mask, polygon, box"),
        ({"min_visibility": -0.1}, "expected a fraction"),
        ({"image_output_format": "bmp"}, "bmp"),
        ({"semantic_types": ["class"], "semantic_filter_predicate": "class:*"}, "exclude each other"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        writers.get("CvatWriter", init_params={"output_dir": str(tmp_path), **options})
