"""`usdsdg verify` reads BasicWriter's files of dense correspondence, and finds what is damaged in them."""

import shutil

import numpy as np
import pytest
from PIL import Image
from pxr import Sdf

import usdsdg as rep
from tests.verify import datasets
from tests.verify.label_faults import edit_array, edit_json
from usdsdg.session import session
from usdsdg.session.stage_context import current_stage
from usdsdg.verify import verify

OTHER = "Replicator"  # the product of the first camera, which the second one's points are looked up in


def write(folder, correspondence, *, frames=1):
    """Write images of the two cameras of `datasets.Scene`, of which the second is a fisheye."""
    session.restart()
    scene = datasets.Scene(3)
    lens = current_stage().GetPrimAtPath(scene.cameras[1])
    lens.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set("fisheyeEquidistant")
    current_stage().GetPrimAtPath("/World/Floor").SetActive(False)
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), dense_correspondence=correspondence or scene.cameras[0])
    writer.attach([rep.create.render_product(camera, (64, 48)) for camera in scene.cameras])
    for _ in range(frames):
        scene.move()
        rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    session.restart()
    assert verify(folder).faults == []
    return folder


@pytest.fixture(scope="module")
def to_a_camera(tmp_path_factory):
    return write(tmp_path_factory.mktemp("camera"), "")


@pytest.fixture(scope="module")
def to_the_last_picture(tmp_path_factory):
    return write(tmp_path_factory.mktemp("before"), True, frames=2)


def shifted(array):
    return array + np.float32(0.5)


def swapped(array):
    return array[..., ::-1]


def filled(array):
    array[np.isnan(array)] = 3.0
    return array


def lost(array):
    array[:] = np.nan
    return array


def array(change):
    return "dense_correspondence_0000.npy", lambda path: edit_array(path, change)


def table(**values):
    return "dense_correspondence_info_0000.json", lambda path: edit_json(path, lambda found: found.update(values))


def states(change):
    def edit(path):
        Image.fromarray(change(np.array(Image.open(path)))).save(path)

    return "dense_correspondence_visibility_0000.png", edit


DAMAGES = {
    "half a pixel": array(shifted),
    "rows for columns": array(swapped),
    "a place of nothing": array(filled),
    "no place": array(lost),
    "fewer rows": array(lambda found: found[1:]),
    "another type": array(lambda found: found.astype(np.float64)),
    "another camera": table(camera="/World"),
    "another size": table(resolution=[32, 24]),
    "all visible": states(lambda found: np.full_like(found, 2)),
    "unknown states": states(lambda found: found + 3),
    "states of another size": states(lambda found: found[:, 1:]),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_what_was_changed_is_found(to_a_camera, tmp_path, name):
    folder = shutil.copytree(to_a_camera, tmp_path / "data", ignore=shutil.ignore_patterns("journal*"))
    file, inject = DAMAGES[name]
    (path,) = folder.glob(f"{OTHER}_01/**/{file}")
    inject(path)
    assert path.relative_to(folder).as_posix() in {fault.file for fault in verify(folder).faults}


@pytest.mark.parametrize("name", ["fewer rows", "all visible", "another camera"])
def test_so_is_what_was_changed_of_points_of_an_earlier_picture(to_the_last_picture, tmp_path, name):
    folder = shutil.copytree(to_the_last_picture, tmp_path / "data", ignore=shutil.ignore_patterns("journal*"))
    file, inject = DAMAGES[name]
    (path,) = folder.glob(f"{OTHER}_01/**/{file.replace('0000', '0001')}")
    inject(path)
    assert path.relative_to(folder).as_posix() in {fault.file for fault in verify(folder).faults}
