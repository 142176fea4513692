"""Writers that are initialized again: what they have written until then is whole."""

import pytest

import usdsdg as rep
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
