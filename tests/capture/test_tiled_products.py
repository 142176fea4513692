"""Several cameras in one image: each tile equals the image of its camera alone."""

import numpy as np
import pytest

import usdsdg as rep
from tests.dataset_files import data_names
from usdsdg.errors import BadPrim, GraphError, RenderError, Unsupported, UsdsdgWarning
from usdsdg.scenarios.saved_pipeline import Overrides, run
from usdsdg.session.stage_context import current_stage, new_stage, save_stage

TILE = (24, 16)
ANNOTATORS = (
    "rgb", "HdrColor", "distance_to_camera", "distance_to_image_plane", "normals", "motion_vectors",
    "semantic_segmentation", "instance_segmentation", "instance_id_segmentation", "PtWorldPos", "Roughness",
)  # fmt: skip


@pytest.fixture
def cameras(stage):
    """Three cameras around a labeled cube and ball."""
    rep.create.light(light_type="Dome", intensity=800)
    rep.create.light(light_type="Sphere", position=(2, 3, 4), scale=0.5, intensity=20000)
    rep.create.cube(semantics=[("class", "cube")])
    rep.create.sphere(position=(0, 2, 0), semantics=[("class", "ball")])
    positions = [(6, 0, 1), (0, 6, 2), (-4, -4, 3)]
    return [rep.create.camera(position=each, look_at=(0, 0, 0), clipping_range=(0.1, 100)) for each in positions]


def attached(product, **params):
    return {name: rep.annotators.get(name, params.get(name)).attach(product) for name in ANNOTATORS}


def arrays(annotators):
    data = {name: annotator.get_data() for name, annotator in annotators.items()}
    return {name: each["data"] if isinstance(each, dict) else each for name, each in data.items()}


def tile_of(array, index, columns=2):
    row, column = divmod(index, columns)
    return array[row * TILE[1] : (row + 1) * TILE[1], column * TILE[0] : (column + 1) * TILE[0]]


def test_each_tile_is_the_image_of_its_camera(cameras):
    tiled = attached(rep.create.render_product_tiled(cameras, TILE))
    rep.orchestrator.step()
    whole = arrays(tiled)
    for annotator in tiled.values():
        annotator.detach()
    new_alone = [attached(rep.create.render_product(camera, TILE)) for camera in cameras]
    rep.orchestrator.stop()
    rep.orchestrator.step()
    for index, alone in enumerate(new_alone):
        for name, array in arrays(alone).items():
            assert whole[name].dtype == array.dtype, name
            assert whole[name].shape == (2 * TILE[1], 2 * TILE[0], *array.shape[2:]), name
            assert np.array_equal(tile_of(whole[name], index), array, equal_nan=True), (name, index)
    # The images of the cameras differ.
    assert not np.array_equal(tile_of(whole["rgb"], 0), tile_of(whole["rgb"], 1))


def test_pixels_outside_all_tiles_have_the_miss_value(cameras):
    tiled = attached(rep.create.render_product_tiled(cameras, TILE))
    rep.orchestrator.step()
    empty = {name: tile_of(array, 3) for name, array in arrays(tiled).items()}
    assert np.isposinf(empty["distance_to_camera"]).all()
    assert (empty["semantic_segmentation"] == 0).all()
    assert (empty["rgb"] == 0).all()
    assert (empty["normals"][..., :3] == 0).all()
    labels = tiled["semantic_segmentation"].get_data()["info"]["idToLabels"]
    assert {"class": "cube"} in labels.values()


def test_motion_vectors_are_those_of_each_camera(cameras):
    product = rep.create.render_product_tiled(cameras[:2], TILE)
    motion = rep.annotators.get("motion_vectors").attach(product)
    rep.orchestrator.step()
    with cameras[0]:
        rep.modify.pose(position=(6, 0.5, 1), look_at=(0, 0, 0))
    rep.orchestrator.step()
    data = motion.get_data()
    assert np.abs(tile_of(data, 0)).max() > 0.1
    assert np.abs(tile_of(data, 1)).max() == 0


@pytest.mark.parametrize(
    ("count", "grid"), [(1, (1, 1)), (2, (2, 1)), (3, (2, 2)), (5, (3, 2)), (7, (3, 3)), (9, (3, 3))]
)
def test_the_grid_has_as_many_rows_as_needed(count, grid):
    new_stage()
    product = rep.create.render_product_tiled(rep.create.camera(count=count), tile_resolution=(8, 4))
    assert (product.width, product.height) == (grid[0] * 8, grid[1] * 4)
    prim = current_stage().GetPrimAtPath(product.path)
    assert len(prim.GetRelationship("camera").GetTargets()) == count
    assert tuple(prim.GetAttribute("resolution").Get()) == product.resolution


def test_the_same_cameras_and_tiles_are_one_product(cameras):
    first = rep.create.render_product_tiled(cameras, TILE)
    assert rep.create.render_product_tiled(cameras, TILE) is first
    assert rep.create.render_product_tiled(cameras[::-1], TILE) is not first
    assert rep.create.render_product_tiled(cameras, TILE, force_new=True) is not first
    assert rep.create.render_product_tiled(cameras, TILE, name="grid").name == "grid"
    # A product of one camera with the same image size is another product.
    assert rep.create.render_product(cameras[0], first.resolution) is not first


@pytest.mark.parametrize("name", ["bounding_box_2d_tight", "bounding_box_3d", "occlusion", "camera_params"])
def test_annotators_that_need_one_camera_raise(cameras, name):
    product = rep.create.render_product_tiled(cameras, TILE)
    annotator = rep.annotators.get(name).attach(product)
    try:
        with pytest.raises(Unsupported, match=f"{product.path}.*create.render_product"):
            rep.orchestrator.step()
    finally:
        annotator.detach()


def test_a_writer_receives_the_tiled_image_and_a_saved_stage_restores_it(cameras, tmp_path):
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path / "first"), rgb=True, distance_to_camera=True, semantic_segmentation=True)
    writer.attach(rep.create.render_product_tiled(cameras, TILE))
    with rep.trigger.on_frame():
        rep.modify.pose(rotation=rep.distribution.uniform((0, 0, 0), (0, 0, 90)), input_prims="/Replicator/Cube_Xform")
    for _ in range(2):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    save_stage(tmp_path / "scene.usda")
    writer.detach()
    files = data_names(tmp_path / "first")
    assert "rgb_0001.png" in files
    run(tmp_path / "scene.usda", Overrides(output_dir=str(tmp_path / "again")))
    for name in files:
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "first" / name).read_bytes(), name


def test_invalid_tiles_raise(cameras):
    with pytest.raises(BadPrim, match="no cameras were given; cameras on the stage: /Replicator/Camera_Xform"):
        rep.create.render_product_tiled([], TILE)
    with pytest.raises(BadPrim, match="/Replicator/Cube_Xform is a Xform without a camera"):
        rep.create.render_product_tiled(["/Replicator/Cube_Xform"], TILE)
    with pytest.raises(TypeError, match="tile_resolution must be"):
        rep.create.render_product_tiled(cameras, 16)
    with pytest.raises(RenderError, match="20000 x 4 pixels"):
        rep.create.render_product_tiled(cameras, (10000, 2))


def test_a_tiled_sensor_is_the_same_in_two_steps(cameras):
    tiled = attached(rep.create.render_product_tiled(cameras, TILE))
    rep.orchestrator.step()
    expected = arrays(tiled)
    for annotator in tiled.values():
        annotator.detach()
    whole = (2 * TILE[0], 2 * TILE[1])
    with pytest.warns(UsdsdgWarning, match="render_product_tiled"):
        sensor = rep.create.tiled_sensor(cameras, TILE, whole, output_types=["rgb", "depth"], name="all_of_them")
    prim = current_stage().GetPrimAtPath(f"{sensor.prims[0]}/all_of_them")
    bridge = current_stage().GetPrimAtPath(prim.GetAttribute("sensorModelConfig").Get())
    assert len(bridge.GetRelationship("camPrims").GetTargets()) == 3
    assert list(bridge.GetAttribute("outputType").Get()) == ["rgb", "depth"]
    again = attached(rep.create.render_product(sensor, whole))
    rep.orchestrator.stop()
    rep.orchestrator.step()
    for name, array in arrays(again).items():
        assert np.array_equal(array, expected[name], equal_nan=True), name
    with pytest.raises(RenderError, match=r"tiled sensor of 48 x 32 pixels, not 64 x 64"):
        rep.create.render_product(sensor, (64, 64))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (((8, 8), (20, 16)), "not a multiple of camera_resolution"),
        (((8, 8), (16, 8)), "room for 2 tiles, not for 3"),
        (((8, 8), (16, 16), ["normals"]), "expected some of rgb, depth"),
    ],
)
def test_invalid_tiled_sensors_raise(cameras, arguments, words):
    with pytest.raises(GraphError, match=words):
        rep.create.tiled_sensor(cameras, *arguments)
