"""`usdsdg verify` reads values that training asks for and no picture shows: each is damaged, without a journal."""

import shutil

import numpy as np
import pytest
import yaml
from PIL import Image

from tests.verify import datasets
from tests.verify.label_faults import edit_json
from usdsdg.verify import verify

NAMES = ("pose", "dope", "yolo", "keypoints", "kitti", "coco", "coco_plain", "cvat")


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = datasets.make(tmp_path_factory.mktemp("datasets"), NAMES, frames=3)
    for name in NAMES:
        assert verify(folder / name).faults == []
    return folder


def first_object(path, change):
    edit_json(path, lambda values: change(values["objects"][0]))


def more_truncated(each):
    each["truncation_ratio"] += 0.02


def described(path, /, **values):
    """Set values of a YAML file; None removes one."""
    known = yaml.safe_load(path.read_text()) | values
    path.write_text(yaml.safe_dump({name: value for name, value in known.items() if value is not None}))


def keypoint(path, index, change):
    """Change the numbers of a keypoint of the first line that has one in the picture, or none."""
    lines = [line.split(" ") for line in path.read_text().splitlines()]
    for fields in lines:
        points = [fields[start : start + 3] for start in range(5, len(fields), 3)]
        if (points[index][2] != "0") == (change != "add"):
            points[index] = ["0.5", "0.5", "2"] if change == "add" else change(points[index])
            fields[5:] = [number for point in points for number in point]
            break
    else:
        raise AssertionError("no line has such a keypoint")
    path.write_text("".join(" ".join(fields) + "\n" for fields in lines))


def paint(path):
    pixels = np.array(Image.open(path))
    pixels[np.unravel_index((pixels[..., :3].sum(axis=2) == 0).argmax(), pixels.shape[:2])] = (9, 9, 9, 255)
    Image.fromarray(pixels).save(path)


def category(**values):
    return lambda path: edit_json(path, lambda known: known["categories"][0].update(values))


def label(change):
    return lambda path: edit_json(path, lambda known: change(known[0]))


DAMAGES = {
    "a truncation": ("pose", "*.json", lambda p: first_object(p, more_truncated)),
    "no truncation": ("dope", "*.json", lambda p: first_object(p, lambda o: o.pop("truncation_ratio"))),
    "no size": ("pose", "*.json", lambda p: first_object(p, lambda o: o.pop("size"))),
    "no location": ("dope", "*.json", lambda p: first_object(p, lambda o: o.pop("location"))),
    "another folder of pictures": ("yolo", "data.yaml", lambda p: described(p, train="images/other")),
    "another folder for validation": ("yolo", "data.yaml", lambda p: described(p, val="images/other")),
    "no folder for validation": ("yolo", "data.yaml", lambda p: described(p, val=None)),
    "values of keypoints": ("keypoints", "data.yaml", lambda p: described(p, kpt_shape=[3, 4])),
    "a moved keypoint": (
        "keypoints", "labels/*/*2.txt", lambda p: keypoint(p, 1, lambda k: [str(float(k[0]) + 0.01), *k[1:]])
    ),
    "a keypoint that is gone": ("keypoints", "labels/*/*2.txt", lambda p: keypoint(p, 1, lambda k: ["0", "0", "0"])),
    "a keypoint that is not there": ("keypoints", "labels/*/*2.txt", lambda p: keypoint(p, 0, "add")),
    "a color where nothing is": ("kitti", "*/instance_rgb/1.png", paint),
    "a thing that is stuff": ("coco", "coco_annotations_*.json", category(isthing=0)),
    "another color of a category": ("coco", "coco_annotations_*.json", category(color=[1, 2, 3])),
    "another color of a class": ("coco_plain", "annotations/instances_train.json", category(color=[1, 2, 3])),
    "another supercategory": ("coco", "coco_annotations_*.json", category(supercategory="thing")),
    "another color of a label": ("cvat", "labels.json", label(lambda each: each.update(color="#000000"))),
    "an attribute of another name": ("cvat", "labels.json", label(lambda each: each["attributes"][0].update(name="x"))),
    "no attribute": ("cvat", "labels.json", label(lambda each: each.update(attributes=[]))),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGES)
def test_a_value_that_was_changed_is_found(clean, tmp_path, name):
    dataset, pattern, inject = DAMAGES[name]
    folder = shutil.copytree(clean / dataset, tmp_path / "data")
    file = sorted(path for path in folder.glob(pattern) if path.name != "metadata.txt")[0]
    inject(file)
    named = {fault.file for fault in verify(folder).faults}
    assert file.relative_to(folder).as_posix() in named


def test_what_others_add_to_the_description_is_no_fault(clean, tmp_path):
    folder = shutil.copytree(clean / "yolo", tmp_path / "data")
    described(folder / "data.yaml", path=str(folder), nc=4)
    assert verify(folder).faults == []
