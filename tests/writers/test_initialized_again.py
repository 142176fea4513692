"""Writers that are initialized again: what they have written until then is whole."""

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
