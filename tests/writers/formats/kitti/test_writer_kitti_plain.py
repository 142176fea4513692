"""KittiWriter in KITTI's own layout: the files that the development kit and its readers look for."""

import numpy as np
import pytest
from PIL import Image

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import street
from tests.dataset_files import data_names
from tests.writers.formats.kitti.test_writer_kitti import PRODUCT, lines, write
from usdsdg import writers
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import kitti
from usdsdg.errors import UsdsdgWarning, WriterError, forget_warnings
from usdsdg.session.stage_context import set_stage
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.kitti import files

KINDS = ("calib", "depth", "image_2", "instance", "label_2", "semantic", "semantic_rgb")


@pytest.fixture(scope="module")
def frame():
    return make_frame(set_stage(street()), (64, 48), filters=["class:*"])


def test_pictures_are_in_training_and_lists_name_the_parts(frame, tmp_path):
    folder = write(tmp_path, [frame] * 5, splits={"train": 3, "val": 2})
    suffix = {"calib": "txt", "label_2": "txt"}
    expected = [f"training/{kind}/{n:06d}.{suffix.get(kind, 'png')}" for kind in KINDS for n in range(5)]
    assert data_names(folder) == sorted([*expected, "ImageSets/train.txt", "ImageSets/val.txt", "metadata.txt"])
    lists = [(folder / files.image_set(part)).read_text().splitlines() for part in ("train", "val")]
    assert [len(each) for each in lists] == [3, 2]
    assert sorted(lists[0] + lists[1]) == [f"{n:06d}" for n in range(5)]


def test_without_splits_all_pictures_are_for_training(frame, tmp_path):
    folder = write(tmp_path, [frame] * 2, plain_names=True)
    assert (folder / "ImageSets/train.txt").read_text() == "000000\n000001\n"
    assert not (folder / "ImageSets/val.txt").exists()


def test_frames_of_a_scene_are_in_one_part(frame, tmp_path):
    folder = write(tmp_path, [frame] * 6, splits={"train": 1, "val": 1}, frames_per_scene=2)
    assert (folder / "ImageSets/train.txt").read_text().split() == ["000000", "000001", "000004", "000005"]
    assert (folder / "ImageSets/val.txt").read_text().split() == ["000002", "000003"]


def test_the_files_have_what_those_of_replicators_layout_have(frame, tmp_path):
    plain = write(tmp_path / "plain", frame, plain_names=True) / "training"
    other = write(tmp_path / "other", frame, omit_semantic_type=True, use_kitti_dir_names=True) / "Camera"
    for own, theirs in zip(KINDS, ("calib", "depth", "image_02", "instance", "label_02", "semantic", "semantic_rgb")):
        extension = "txt" if own in ("calib", "label_2") else "png"
        expected = (other / theirs / f"0.{extension}").read_bytes()
        assert (plain / own / f"000000.{extension}").read_bytes() == expected


def test_cameras_of_a_frame_are_in_one_row_and_in_one_part(frame, tmp_path):
    empty = make_frame(set_stage(new_stage()), (64, 48), filters=["class:*"])
    folder = write(tmp_path, [{PRODUCT: frame, f"{PRODUCT}2": empty}] * 4, splits={"train": 1, "val": 1})
    counts = [len(lines(folder / f"training/label_2/{n:06d}.txt")) for n in range(8)]
    assert counts[0] > 2
    assert counts == [counts[0], 0] * 4
    for part in ("train", "val"):
        numbers = np.array((folder / files.image_set(part)).read_text().split(), int)
        assert (numbers[::2] % 2 == 0).all()
        assert (numbers[1::2] == numbers[::2] + 1).all()
    assert [seen.frame for seen in kitti.read(Folder(folder), Folder(folder).files)] == [f"{n:06d}" for n in range(8)]


def test_names_have_no_type_and_no_blanks(tmp_path):
    stage = set_stage(new_stage())
    add_labels(add_cube(stage, "/World/Wheel"), {"part": ["wheel"], "class": ["Rear & front <wheel>"]})
    folder = write(tmp_path, make_frame(stage, (16, 12)), plain_names=True)
    ((name, _),) = lines(folder / "training/label_2/000000.txt")
    assert name == "Rear_&_front_<wheel>".lower()


@pytest.mark.parametrize("options", [{}, {"plain_names": True}])
def test_two_classes_of_one_name_are_an_error(options, tmp_path):
    stage = set_stage(new_stage())
    add_cube(stage, "/World/One", "sp ace", translate=(-1, 0, 0))
    add_cube(stage, "/World/Two", "sp_ace", translate=(1, 0, 0))
    with pytest.raises(WriterError, match=r"would both be called (class:)?sp_ace"):
        write(tmp_path, make_frame(stage, (16, 12)), **options)


def test_a_class_that_the_evaluation_leaves_out_is_told(tmp_path):
    forget_warnings()
    stage = set_stage(new_stage())
    add_cube(stage, "/World/One", "DontCare")
    with pytest.warns(UsdsdgWarning, match="KITTI's evaluation leaves out objects of the class 'dontcare'"):
        write(tmp_path, make_frame(stage, (16, 12)), plain_names=True)


def test_a_row_and_a_column_of_the_picture_count_from_0_and_are_inclusive(tmp_path):
    stage = set_stage(new_stage())
    add_cube(stage, "/World/Wall", "wall", scale=(50, 50, 1))
    folder = write(tmp_path, make_frame(stage, (16, 12)), plain_names=True)
    ((_, numbers),) = lines(folder / "training/label_2/000000.txt")
    with Image.open(folder / "training/image_2/000000.png") as image:
        width, height = image.size
    assert numbers[3:7].tolist() == [0, 0, width - 1, height - 1]


def test_what_is_hidden_is_unknown_where_no_ratio_is_known(tmp_path):
    writer = writers.get("KittiWriter", init_params={"output_dir": str(tmp_path)})
    assert [writer._occlusion_level(visible) for visible in (1.0, 0.6, 0.1, float("nan"))] == [0, 1, 2, 3]


def test_what_is_visible_by_just_a_threshold_has_its_level_although_ratios_are_rounded(tmp_path):
    writer = writers.get("KittiWriter", init_params={"output_dir": str(tmp_path)})
    hidden = np.array([1 / 20, 3 / 6], np.float32)  # the first is a little more
    assert [writer._occlusion_level(1.0 - float(each)) for each in hidden] == [0, 1]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"splits": {"train": 1}, "plain_names": False}, "splits need plain_names"),
        ({"plain_names": True, "use_kitti_dir_names": True}, "leave out plain_names and splits"),
        ({"splits": {"train": 1}, "use_kitti_dir_names": True}, "leave out plain_names and splits"),
        ({"splits": {"train": 0}}, "expected shares above 0"),
        ({"plain_names": "yes"}, "expected true or false or None"),
    ],
)
def test_wrong_options_are_refused(options, message, tmp_path):
    with pytest.raises(WriterError, match=message):
        writers.get("KittiWriter", init_params={"output_dir": str(tmp_path), **options})
