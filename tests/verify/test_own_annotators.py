"""`usdsdg verify` reads BasicWriter's files of annotators beyond Replicator's, and finds what is damaged in them."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image
from pxr import Sdf

import usdsdg as rep
from tests.verify import datasets
from tests.verify.label_faults import edit_array, edit_json, edit_rows
from usdsdg.session import session
from usdsdg.session.stage_context import current_stage
from usdsdg.verify import verify

KINDS = (
    "amodal_instance_segmentation", "visibility", "truncation", "bounding_box_2d_amodal", "oriented_bounding_box_2d",
    "oriented_bounding_box_2d_amodal", "object_coordinates", "keypoints",
)  # fmt: skip


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """A frame, with the camera of `datasets.Scene` and a fisheye that sees things reach out of the picture."""
    folder = tmp_path_factory.mktemp("own")
    session.restart()
    scene = datasets.Scene(3)
    lens = current_stage().GetPrimAtPath(scene.cameras[1])
    lens.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeEquidistant")
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), **dict.fromkeys(KINDS, True))
    writer.attach([rep.create.render_product(camera, (64, 48)) for camera in scene.cameras])
    scene.move()
    rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    session.restart()
    assert verify(folder).faults == []
    return folder


def rows(**changes):
    """Change fields of the first row of a structured array."""

    def edit(array):
        for name, change in changes.items():
            array[name][0] = change(array[name][0])

    return lambda path: edit_rows(path, edit)


def table(change):
    return lambda path: edit_json(path, change)


def shorter(runs):
    """Move the end of a mask's first run by a pixel."""
    counts = runs["counts"]
    counts[0], counts[1] = counts[0] + 1, counts[1] - 1


def coordinates(path):
    def edit(array):
        shown = array[..., 3] > 0
        array[shown, 0] = 1 - array[shown, 0]
        return array

    edit_array(path, edit)


def other_levels(path):
    levels = np.array(Image.open(path))
    levels[levels[..., 3] > 0, 1] //= 2
    Image.fromarray(levels).save(path)


DAMAGES = {
    "visible pixels": ("visibility_0000.npy", rows(visiblePixels=lambda v: v + 1)),
    "a box of visibility": ("visibility_0000.npy", rows(x_max=lambda v: v + 1)),
    "a visible fraction": ("visibility_0000.npy", rows(visibleRatio=lambda v: v / 2)),
    "a class of visibility": ("visibility_0000.npy", rows(semanticId=lambda v: v + 1)),
    "hidden by fewer pixels": ("visibility_info_0000.json", table(lambda v: v["hiddenBy"][-1].update({"1": 12345}))),
    "without hiddenBy": ("visibility_info_0000.json", table(lambda v: v.pop("hiddenBy"))),
    "a path of visibility": ("visibility_info_0000.json", table(lambda v: v["primPaths"].reverse())),
    "names of ids": ("visibility_info_0000.json", table(lambda v: v.update(idToLabels={}))),
    "an object that is truncated": ("truncation_0000.npy", rows(instanceId=lambda v: v + 90)),
    "a truncation": ("truncation_0000.npy", rows(truncationRatio=lambda v: v + 0.1)),
    "a corner of a whole box": ("bounding_box_2d_amodal_0000.npy", rows(x_min=lambda v: v + 40)),
    "a path of a whole box": ("bounding_box_2d_amodal_prim_paths_0000.json", table(lambda v: [*v[:-1], "/World"])),
    "labels of whole boxes": ("bounding_box_2d_amodal_labels_0000.json", table(lambda v: v["0"].update(x="y"))),
    "occlusion of a whole box": ("bounding_box_2d_amodal_0000.npy", rows(occlusionRatio=lambda v: 1 - v)),
    "an angle": ("oriented_bounding_box_2d_0000.npy", rows(angle=lambda v: v + 3)),
    "a side": ("oriented_bounding_box_2d_amodal_0000.npy", rows(width=lambda v: 1.1 * v)),
    "a place": ("oriented_bounding_box_2d_0000.npy", rows(x=lambda v: v + 5, corners=lambda v: v + np.array([5, 0]))),
    "a run of a mask": (
        "amodal_instance_segmentation_info_0000.json", table(lambda v: shorter(v["masks"][0]))
    ),
    "runs that do not add up": (
        "amodal_instance_segmentation_info_0000.json", table(lambda v: v["masks"][0]["counts"].append(3))
    ),
    "labels of a mask": (
        "amodal_instance_segmentation_info_0000.json",
        table(lambda v: next(iter(v["idToSemantics"].values())).update({"class": "x"})),
    ),
    "coordinates from the other side": ("object_coordinates_0000.npy", coordinates),
    "levels of coordinates": ("object_coordinates_0000.png", other_levels),
    "a box of coordinates": ("object_coordinates_info_0000.json", table(lambda v: v["boxes"][0][0].reverse())),
    "a keypoint's column": ("keypoints_0000.npy", rows(x=lambda v: v + 0.5)),
    "a keypoint in the world": ("keypoints_0000.npy", rows(position=lambda v: v + 0.01)),
    "a keypoint of another name": ("keypoints_0000.npy", rows(keypointId=lambda v: v + 1)),
    "a keypoint's distance": ("keypoints_0000.npy", rows(distance=lambda v: 1.01 * v)),
    "names of keypoints": ("keypoints_info_0000.json", table(lambda v: v["keypointNames"].reverse())),
    "an array of another type": ("truncation_0000.npy", lambda p: np.save(p, np.zeros(3, np.float32))),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGES)
def test_what_was_changed_is_found(clean, tmp_path, name):
    folder = shutil.copytree(clean, tmp_path / "data")
    file, inject = DAMAGES[name]
    (path,) = folder.glob(f"Replicator/**/{file}")
    inject(path)
    found = {fault.file for fault in verify(folder).faults}
    kind = path.parent.name
    assert any(f"Replicator/{kind}/" in each for each in found), json.dumps(sorted(found))
