"""VocWriter: XML, segments and lists against the masks of the frame, as the readers of Pascal VOC take them."""

from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.dataset_files import data_names
from tests.writers.formats.test_writer_yolo import PRODUCT, labeled_in_view
from tests.writers.formats.test_writer_yolo import write as written
from usdsdg import writers
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.session import current
from usdsdg.verify import verify
from usdsdg.writers.formats.voc import files

SIZE = (64, 48)
write = partial(written, kind="VocWriter")


pytestmark = pytest.mark.usefixtures("classes_of_the_frame")


def objects(folder, stem="000000"):
    """Return name, flags and sides of each object of a picture's XML."""
    root = ElementTree.parse(folder / f"Annotations/{stem}.xml").getroot()
    flags = ("truncated", "occluded", "difficult")
    return [
        (
            each.findtext("name"),
            {name: int(each.findtext(name)) for name in flags},
            [int(each.findtext(f"bndbox/{side}")) for side in ("xmin", "ymin", "xmax", "ymax")],
        )
        for each in root.iterfind("object")
    ]


def indices(folder, kind, stem="000000"):
    with Image.open(folder / f"{kind}/{stem}.png") as image:
        assert image.mode == "P"
        return np.array(image), np.array(image.getpalette()).reshape(-1, 3)


def test_boxes_count_from_1_and_are_inclusive(frame, tmp_path):
    folder = write(tmp_path, [frame])
    expected = labeled_in_view(frame)
    found = objects(folder)
    assert [name for name, _, _ in found] == [name for name, _ in expected]
    assert len(expected) > 2
    for (_, _, box), (_, mask) in zip(found, expected):
        rows, columns = np.nonzero(mask)
        assert box == [columns.min() + 1, rows.min() + 1, columns.max() + 1, rows.max() + 1]


def test_what_fills_the_picture_has_a_box_from_1_to_its_size(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/Wall", "wall", scale=(50, 50, 1))
    folder = write(tmp_path, [make_frame(stage, (16, 12), filters=["class:*"])])
    ((name, flags, box),) = objects(folder)
    assert (name, box) == ("wall", [1, 1, 16, 12])
    assert flags == {"truncated": 1, "occluded": 0, "difficult": 0}
    root = ElementTree.parse(folder / "Annotations/000000.xml").getroot()
    assert [root.findtext(f"size/{each}") for each in ("width", "height", "depth")] == ["16", "12", "3"]
    assert (root.findtext("filename"), root.findtext("segmented")) == ("000000.jpg", "1")


def test_segments_are_indices_of_classes_and_of_objects(frame, tmp_path):
    folder = write(tmp_path, [frame])
    (classes, colors), (own, palette) = (indices(folder, kind) for kind in (files.CLASSES, files.OBJECTS))
    rows = (folder / files.LABELS).read_text().splitlines()[1:]
    names, listed = zip(*(row.split(":")[:2] for row in rows))
    expected = np.zeros((48, 64), int), np.zeros((48, 64), int)
    for number, (name, mask) in enumerate(labeled_in_view(frame), 1):
        expected[0][mask], expected[1][mask] = names.index(name), number
    np.testing.assert_array_equal(classes, expected[0])
    np.testing.assert_array_equal(own, expected[1])
    # VOC's first colors, and that of the border.
    assert colors[[0, 1, 2, 3, 8, 255]].tolist() == palette[[0, 1, 2, 3, 8, 255]].tolist()
    assert colors[[0, 1, 2, 3, 8, 255]].tolist() == [
        [0, 0, 0], [128, 0, 0], [0, 128, 0], [128, 128, 0], [64, 0, 0], [224, 224, 192],
    ]  # fmt: skip
    assert [tuple(map(int, each.split(","))) for each in listed] == [tuple(each) for each in colors[: len(names)]]
    assert names[0] == "background"


def test_lists_have_every_picture_once_and_say_which_show_a_class(frame, tmp_path):
    folder = write(tmp_path, [frame] * 5, splits={"train": 3, "val": 2}, min_visibility=0.9)
    every = []
    for part in ("train", "val"):
        stems = (folder / f"ImageSets/Main/{part}.txt").read_text().split()
        assert (folder / f"ImageSets/Segmentation/{part}.txt").read_text().split() == stems
        every += stems
        # One apple is half hidden, the other is not; nothing shows the cube below the pear.
        for name, said in (("apple", " 1"), ("pear", " 1"), ("secret", "-1")):
            text = (folder / f"ImageSets/Main/{name}_{part}.txt").read_text()
            assert text == "".join(f"{stem} {said}\n" for stem in stems)
    assert sorted(every) == [f"{number:06d}" for number in range(5)]
    assert len([name for name in data_names(folder) if name.startswith("JPEGImages/")]) == 5


def test_frames_of_a_scene_are_in_one_part(frame, tmp_path):
    folder = write(tmp_path, [frame] * 6, splits={"train": 1, "val": 1}, frames_per_scene=2)
    assert (folder / "ImageSets/Main/train.txt").read_text().split() == ["000000", "000001", "000004", "000005"]
    assert (folder / "ImageSets/Main/val.txt").read_text().split() == ["000002", "000003"]


def test_a_class_is_0_where_all_its_objects_are_difficult(frame, tmp_path):
    folder = write(tmp_path, [frame], min_pixels=10_000)
    assert {flags["difficult"] for _, flags, _ in objects(folder)} == {1}
    assert (folder / "ImageSets/Main/apple_train.txt").read_text() == "000000  0\n"


def test_flags_follow_the_thresholds(frame, tmp_path):
    _, visible = zip(*labeled_in_view(frame))
    hidden = frame.occlusion("class:*")[np.flatnonzero(frame.visible_pixels("class:*") > 0)]
    assert 0 < hidden.max() < 1
    folder = write(tmp_path / "a", [frame], occluded_threshold=float(hidden.max()) - 1e-3)
    assert [flags["occluded"] for _, flags, _ in objects(folder)] == (hidden == hidden.max()).astype(int).tolist()
    folder = write(tmp_path / "b", [frame], occluded_threshold=float(hidden.max()) + 1e-3)
    assert not any(flags["occluded"] for _, flags, _ in objects(folder))
    folder = write(tmp_path / "c", [frame], min_visibility=float(1 - hidden.max()) + 1e-3)
    assert [flags["difficult"] for _, flags, _ in objects(folder)] == (hidden == hidden.max()).astype(int).tolist()
    least = sorted(int(mask.sum()) for mask in visible)[1]
    folder = write(tmp_path / "d", [frame], min_pixels=least)
    assert [flags["difficult"] for _, flags, _ in objects(folder)] == [int(mask.sum() < least) for mask in visible]


@pytest.mark.parametrize(("beyond", "truncated"), [(0.0, 0), (0.1, 0), (0.3, 1), (0.6, 1)])
def test_what_reaches_out_of_the_picture_is_truncated(beyond, truncated, tmp_path):
    stage = new_stage()
    # The camera is ten above: at its upper face, nine and a half below, the picture is this wide.
    width = 9.5 * 20.955 / 24.0
    add_cube(stage, "/World/Box", "box", translate=(width / 2 - 0.5 + beyond, 0, 0))
    folder = write(tmp_path, [make_frame(stage, (96, 72), filters=["class:*"])])
    ((_, flags, _),) = objects(folder)
    assert flags["truncated"] == truncated


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("salt & 'pepper'", "salt & 'pepper'"), ("grüne tasse", "grüne tasse"), ("car.red-2,", None),
        ("a:b", "a_b"), ("bin/left", "bin_left"), ("<mug>", "_mug_"), ("#1", "_1"), ("two\nlines", "two_lines"),
        ("bell\x07", "bell_"), ("background", "background_"),
    ],
)  # fmt: skip
def test_names_of_classes_fit_xml_lists_and_files(label, name, tmp_path):
    forget_warnings()
    stage = new_stage()
    add_cube(stage, "/World/Odd", label)
    frame = make_frame(stage, (16, 12), filters=["class:*"])
    name = name or label
    if name == label:
        folder = write(tmp_path, [frame])
    else:
        with pytest.warns(UsdsdgWarning, match="since the format cannot have all of it"):
            folder = write(tmp_path, [frame])
    ((told, _, _),) = objects(folder)
    assert told == name
    lines = (folder / files.LABELS).read_text().splitlines()
    assert f"{name}:" in [line[: len(name) + 1] for line in lines]
    assert {line.count(":") for line in lines} == {3}
    assert (folder / f"ImageSets/Main/{name}_train.txt").read_text() == "000000  1\n"


def test_two_classes_of_one_name_are_an_error(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/One", "a:b", translate=(-1, 0, 0))
    add_cube(stage, "/World/Two", "a/b", translate=(1, 0, 0))
    with pytest.raises(WriterError, match="several classes would be called a_b"):
        write(tmp_path, [make_frame(stage, (16, 12), filters=["class:*"])])


def test_a_class_and_a_part_that_would_have_one_list_are_an_error(tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/One", "small")
    frame = make_frame(stage, (16, 12), filters=["class:*"])
    write(tmp_path / "apart", [frame], splits={"train": 1, "large_train": 1})
    with pytest.raises(WriterError, match=r"ImageSets/Main/small_train\.txt would be the list of two"):
        write(tmp_path / "same", [frame], splits={"train": 1, "small_train": 1})


@pytest.mark.parametrize(("label", "fits"), [("ü" * 122, True), ("ü" * 123, False), ("a" * 300, False)])
def test_a_name_that_is_too_long_for_a_file_is_an_error_at_once(label, fits, tmp_path):
    stage = new_stage()
    add_cube(stage, "/World/Long", label)
    frame = make_frame(stage, (16, 12), filters=["class:*"])
    if fits:  # with "_train.txt" 254 bytes
        assert (write(tmp_path, [frame]) / f"ImageSets/Main/{label}_train.txt").is_file()
    else:
        with pytest.raises(WriterError, match=r"names of files have at most 255. Shorten its label"):
            write(tmp_path, [frame])
        assert not list(tmp_path.rglob("*.jpg"))


def test_more_classes_than_indices_are_an_error(frame, tmp_path):
    current().class_tables.of("class:*").add({"class": f"kind_{number}"} for number in range(255))
    with pytest.raises(WriterError, match="have at most 254"):
        write(tmp_path, [frame])


def test_more_objects_than_indices_are_void(stage, tmp_path):
    forget_warnings()
    create = rep.functional.create
    for number in range(260):
        place = (number % 20 - 9.5, 0, number // 20 - 6)
        create.cube(position=place, scale=0.5, semantics={"class": "cube"})
    rep.create.light(light_type="dome")
    writer = rep.WriterRegistry.get("VocWriter")
    writer.initialize(output_dir=str(tmp_path))
    camera = create.camera(position=(0, -25, 0), look_at=(0, 0, 0))
    writer.attach(rep.create.render_product(camera, (240, 180)))
    with pytest.warns(UsdsdgWarning, match="more than 254 objects"):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    found = objects(tmp_path)
    assert len(found) > 255
    own, _ = indices(tmp_path, files.OBJECTS)
    assert np.unique(own).tolist() == list(range(256))
    for number, (_, _, (left, top, right, bottom)) in enumerate(found, 1):
        assert set(own[top - 1 : bottom, left - 1 : right].ravel().tolist()) - {0} == {min(number, 255)}
    assert verify(tmp_path).faults == []


def test_a_picture_without_objects_has_all_its_files(tmp_path):
    current().class_tables.reset()
    folder = write(tmp_path, [make_frame(new_stage(), (16, 12), filters=["class:*"])])
    assert objects(folder) == []
    assert not indices(folder, files.CLASSES)[0].any()
    assert not indices(folder, files.OBJECTS)[0].any()
    assert (folder / files.LABELS).read_text().splitlines()[1:] == ["background:0,0,0::"]
    assert (folder / "ImageSets/Main/train.txt").read_text() == "000000\n"


def test_products_have_files_of_their_own(frame, tmp_path):
    folder = write(tmp_path, [{PRODUCT: frame, f"{PRODUCT}2": frame}], image_output_format="png", frame_padding=3)
    assert sorted(path.name for path in (folder / files.PICTURES).iterdir()) == ["rp12_000.png", "rp1_000.png"]
    assert objects(folder, "rp1_000") == objects(folder, "rp12_000")
    with Image.open(folder / "JPEGImages/rp1_000.png") as image:
        np.testing.assert_array_equal(np.array(image), frame.aovs["LdrColor"][..., :3])


def test_classes_that_come_later_are_in_all_lists(stage, tmp_path):
    create = rep.functional.create
    create.cube(scale=0.4, semantics={"class": "pear"})
    writer = rep.WriterRegistry.get("VocWriter")
    writer.initialize(output_dir=str(tmp_path))
    camera = create.camera(position=(0, -5, 0), look_at=(0, 0, 0))
    writer.attach(rep.create.render_product(camera, SIZE))
    rep.orchestrator.step()
    create.cube(position=(0, 0, 1), scale=0.4, semantics={"class": "fig"})
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert (tmp_path / "ImageSets/Main/fig_train.txt").read_text() == "000000 -1\n000001  1\n"
    assert (tmp_path / "ImageSets/Main/pear_train.txt").read_text() == "000000  1\n000001  1\n"
    rows = [line.split(":")[0] for line in (tmp_path / files.LABELS).read_text().splitlines()[1:]]
    assert rows == ["background", "pear", "fig"]
    assert verify(tmp_path).faults == []


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"min_visibility": 2.0}, "expected a fraction"),
        ({"splits": {"train": 0}}, "expected shares above 0"),
        ({"splits": {}}, "expected shares above 0"),
        ({"image_output_format": "bmp"}, "bmp"),
        ({"semantic_types": ["class"], "semantic_filter_predicate": "class:*"}, "exclude each other"),
    ],
)
def test_options_that_cannot_be(tmp_path, options, reason):
    with pytest.raises(WriterError, match=reason):
        writers.get("VocWriter", init_params={"output_dir": str(tmp_path), **options})


@pytest.mark.parametrize("name", [".hid", ".h[i]d*"])
def test_a_class_whose_name_begins_with_a_dot_has_no_fault(tmp_path, name):
    add_cube(stage := new_stage(), "/World/cube", label=name)
    current().class_tables.of("class:*").add([{"class": name}])
    folder = write(tmp_path, [make_frame(stage, SIZE, filters=["class:*"])])
    assert any(file.name.startswith(".h") for file in (folder / files.MAIN).iterdir())
    assert verify(folder).faults == []
