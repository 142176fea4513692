"""`usdsdg verify` tells the images of BasicWriter's render products apart, however these are called."""

import pytest

import usdsdg as rep
from usdsdg.verify import verify

OPTIONS = ("rgb", "camera_params", "semantic_segmentation", "distance_to_camera", "normals", "pointcloud")
OTHERS = ("dense_correspondence", "skeleton_data")
NAMES = ("camera", "semantic", "rgb", "pointcloud", "dense", "my_normals", "skeleton", "left")


@pytest.mark.parametrize("common", [False, True])
def test_products_may_be_called_as_annotators_or_their_beginnings_are(stage, tmp_path, common):
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0))
    writer = rep.writers.get("BasicWriter")
    options = dict.fromkeys((*OPTIONS, *OTHERS), True)
    writer.initialize(output_dir=str(tmp_path), use_common_output_dir=common, **options)
    writer.attach([rep.create.render_product(camera, (16, 8), name=name) for name in NAMES])
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    report = verify(tmp_path)
    assert (report.faults, report.notes) == ([], [])
    assert report.formats == {"BasicWriter": len(NAMES)}
