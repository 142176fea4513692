"""`rep.open_dataset`: counts and pictures of what a writer has made."""

import numpy as np
import pytest

import usdsdg as rep
from usdsdg import errors


@pytest.fixture
def folder(tmp_path, stage):
    rep.create.cube(position=(-1, 0, 0), semantics=[("class", "crate")])
    rep.create.sphere(position=(1, 0, 0), semantics=[("class", "ball")])
    rep.create.light(light_type="Dome", intensity=1000)
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), rgb=True, bounding_box_2d_tight=True)
    writer.attach(rep.create.render_product(rep.create.camera(position=(0, -6, 0), look_at=(0, 0, 0)), (60, 40)))
    for _ in range(3):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return tmp_path


def test_a_dataset_has_counts_and_pictures(folder):
    dataset = rep.open_dataset(folder)
    assert len(dataset) == 3
    assert dataset.counts == {"crate": 3, "ball": 3}
    assert dataset.formats == ["BasicWriter"]
    assert dataset.problems == []
    html = dataset._repr_html_()
    assert html.count("<img") == 3
    assert "3 images of BasicWriter, 6 objects" in html


def test_its_pictures_have_the_boxes_of_the_files(folder):
    from PIL import Image

    dataset = rep.open_dataset(folder)
    plain = np.asarray(Image.open(folder / "rgb_0000.png"))[..., :3].astype(int)
    changed = np.abs(np.asarray(dataset[0]).astype(int) - plain).max(axis=2) > 8
    for each in dataset.objects(0):
        left, _top, right, bottom = (int(edge) for edge in each.box)
        assert changed[bottom - 1 : bottom + 1, left:right].any(axis=0).all()
    assert not changed[:, :3].any()


def test_a_folder_without_a_dataset_is_an_error(tmp_path):
    with pytest.raises(errors.DatasetError, match="is empty"):
        rep.open_dataset(tmp_path)
    with pytest.raises(errors.DatasetError, match="does not exist"):
        rep.open_dataset(tmp_path / "none")
