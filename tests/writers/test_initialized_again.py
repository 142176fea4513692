"""Writers that are initialized again: what they have written until then is whole."""

import json

import pytest

import usdsdg as rep
from usdsdg.errors import WriterError
from usdsdg.session.session import current


@pytest.mark.parametrize(
    ("kind", "files"),
    [
        ("CocoWriter", "coco_annotations*.json"),
        ("CvatWriter", "annotations.xml"),
        ("VocWriter", "ImageSets/Main/train.txt"),
        ("BopWriter", "train_pbr/000000/scene_gt.json"),
        ("WebDatasetWriter", "*.tar"),
        ("ParquetWriter", "data/*.parquet"),
    ],
)
def test_a_folder_is_whole_where_the_writer_goes_on_with_another_one(stage, tmp_path, kind, files):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "car")])
    product = rep.create.render_product(rep.create.camera(position=(9, 0, 0), look_at=(0, 0, 0)), (32, 32))
    writer = rep.writers.get(kind)
    for folder in ("first", "second"):
        writer.initialize(output_dir=str(tmp_path / folder))
        writer.attach(product)
        rep.orchestrator.step(delta_time=0.0)
    current().io_queue.wait_until_done()
    assert list(tmp_path.glob(f"first/{files}")), "its frames have another folder now"
    writer.detach()
    current().io_queue.wait_until_done()
    assert list(tmp_path.glob(f"second/{files}"))
    assert len(list(tmp_path.glob(f"first/{files}"))) == 1
    for folder in ("first", "second"):
        table = json.loads((tmp_path / folder / ".usdsdg/classes.json").read_text())
        assert [each["name"] for each in table["tables"][0]["classes"]] == ["car"]


def test_the_list_of_ycb_video_names_the_frames_of_its_folder(stage, tmp_path):
    rep.create.cube(semantics=[("class", "car")])
    product = rep.create.render_product(rep.create.camera(position=(9, 0, 0), look_at=(0, 0, 0)), (32, 32))
    writer = rep.writers.get("YCBVideoWriter")
    for folder, frames in (("first", 1), ("second", 2)):
        writer.initialize(
            output_dir=str(tmp_path / folder), num_frames=5, pose=True, class_name_to_index_map={"car": 1}
        )
        writer.attach(product)
        for _ in range(frames):
            rep.orchestrator.step(delta_time=0.0)
    writer.detach()
    current().io_queue.wait_until_done()
    lists = {folder: (tmp_path / folder / "data/YCB_Video/train.txt").read_text() for folder in ("first", "second")}
    assert lists == {"first": "0000/000000\n", "second": "0000/000000\n0000/000001\n"}


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("KittiWriter", {"splits": {"a/b": 1}}),
        ("KittiWriter", {"fully_visible_threshold": float("nan")}),
        ("KittiWriter", {"mapping_dict": {5: 3}}),
        ("CosmosWriter", {"segmentation_mapping": {"car": "red"}}),
        ("ParquetWriter", {"shard_samples": 0}),
    ],
)
def test_options_that_are_refused_leave_no_folder_and_a_writer_that_can_be_detached(stage, tmp_path, kind, options):
    """As scripts do in the end, whatever failed before."""
    writer = rep.writers.get(kind)
    with pytest.raises(WriterError):
        writer.initialize(output_dir=str(tmp_path / "out"), **options)
    writer.detach()
    assert not (tmp_path / "out").exists()
