"""`usdsdg verify` tells the images of render products apart, however these are called."""

import pytest

import usdsdg as rep
from usdsdg.verify import verify

OPTIONS = ("rgb", "camera_params", "semantic_segmentation", "distance_to_camera", "normals", "pointcloud")
OTHERS = ("dense_correspondence", "skeleton_data")
NAMES = ("camera", "semantic", "rgb", "pointcloud", "dense", "my_normals", "skeleton", "left")


def write(folder, kind, **options):
    """Write a frame of a product of each name; return the report."""
    rep.create.light(light_type="dome")
    rep.create.cube(semantics=[("class", "cube")])
    camera = rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0))
    writer = rep.writers.get(kind)
    writer.initialize(output_dir=str(folder), **options)
    writer.attach([rep.create.render_product(camera, (16, 8), name=name) for name in NAMES])
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return verify(folder)


@pytest.mark.parametrize("common", [False, True])
def test_products_may_be_called_as_annotators_or_their_beginnings_are(stage, tmp_path, common):
    report = write(tmp_path, "BasicWriter", use_common_output_dir=common, **dict.fromkeys((*OPTIONS, *OTHERS), True))
    assert (report.faults, report.notes) == ([], [])
    assert report.formats == {"BasicWriter": len(NAMES)}


@pytest.mark.parametrize("exact", [False, True])
def test_products_of_dope_may_be_called_as_the_folder_of_pictures(stage, tmp_path, exact):
    report = write(tmp_path, "DOPEWriter", class_name_to_index_map={"cube": 1}, exact=exact)
    assert (report.faults, report.notes) == ([], [])
    assert report.formats == {"DOPEWriter": len(NAMES)}
