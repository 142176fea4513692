"""All labels of one frame describe the same scene: checked from the files alone, by the written camera parameters."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import ConvexHull

PRODUCTS = ["Replicator", "Replicator_01"]


def views(folder: Path):
    """(folder of one render product, frame id) of every view that was written."""
    found = [
        (folder / product, path.stem.rsplit("_", 1)[1])
        for product in PRODUCTS
        for path in sorted((folder / product / "camera_params").glob("*.json"))
    ]
    assert len(found) == 4
    return found


def read(view, annotator, stem=None, suffix=".npy"):
    folder, frame = view
    path = folder / annotator / f"{stem or annotator}_{frame}{suffix}"
    if suffix == ".npy":
        return np.load(path)
    return json.loads(path.read_text()) if suffix == ".json" else np.asarray(Image.open(path))


def instance_ids(view):
    """{prim path: id} and the id image."""
    mapping = read(view, "instance_segmentation", "instance_segmentation_mapping", ".json")
    return {path: int(key) for key, path in mapping.items()}, read(view, "instance_segmentation", suffix=".png")


def camera(view):
    params = read(view, "camera_params", suffix=".json")
    width, height = params["renderProductResolution"]
    focal = width * params["cameraFocalLength"] / params["cameraAperture"][0]
    world_to_camera = np.array(params["cameraViewTransform"]).reshape(4, 4)
    return width, height, focal, world_to_camera


def world_points(view):
    """World points (H, W, 3) that pixel centers see, from distance_to_camera alone; inf where nothing is hit."""
    width, height, focal, world_to_camera = camera(view)
    u, v = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    rays = np.stack([u / focal, -v / focal, -np.ones_like(u)], -1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    points = rays * read(view, "distance_to_camera")[..., None].astype(np.float64)
    with np.errstate(invalid="ignore"):
        homogeneous = np.concatenate([points, np.ones_like(points[..., :1])], -1)
        return (homogeneous @ np.linalg.inv(world_to_camera))[..., :3]


def boxes(view, kind):
    rows = read(view, kind)
    paths = read(view, kind, f"{kind}_prim_paths", ".json")
    return dict(zip(paths, rows, strict=True))


def test_labeled_objects_are_visible(labeled):
    assert sum(len(boxes(view, "bounding_box_2d_tight")) for view in views(labeled)) >= 4


def test_tight_boxes_are_the_bounds_of_the_masks(labeled):
    for view in views(labeled):
        ids, image = instance_ids(view)
        for path, row in boxes(view, "bounding_box_2d_tight").items():
            y, x = np.nonzero(image == ids[path])
            assert (row["x_min"], row["y_min"], row["x_max"], row["y_max"]) == (x.min(), y.min(), x.max(), y.max())


def test_every_labeled_instance_in_a_mask_has_a_box_and_every_box_a_mask(labeled):
    for view in views(labeled):
        ids, image = instance_ids(view)
        seen = {path for path, value in ids.items() if value >= 2 and (image == value).any()}
        assert seen == set(boxes(view, "bounding_box_2d_tight"))


def test_loose_boxes_enclose_tight_ones(labeled):
    for view in views(labeled):
        loose = boxes(view, "bounding_box_2d_loose")
        for path, row in boxes(view, "bounding_box_2d_tight").items():
            outer = loose[path]
            assert outer["x_min"] <= row["x_min"]
            assert outer["y_min"] <= row["y_min"]
            assert outer["x_max"] >= row["x_max"]
            assert outer["y_max"] >= row["y_max"]


def test_masks_and_depth_have_the_same_silhouette(labeled):
    for view in views(labeled):
        _, image = instance_ids(view)
        assert np.array_equal(image > 0, np.isfinite(read(view, "distance_to_camera")))
        assert np.array_equal(image, read(view, "instance_segmentation", suffix=".png"))
        semantic = read(view, "semantic_segmentation", suffix=".png")
        assert np.array_equal(semantic >= 2, image >= 2)


def test_both_depths_are_the_same_point(labeled):
    for view in views(labeled):
        width, height, focal, _ = camera(view)
        u, v = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
        stretch = np.sqrt(1 + (u**2 + v**2) / focal**2)
        plane, distance = read(view, "distance_to_image_plane"), read(view, "distance_to_camera")
        hit = np.isfinite(distance)
        assert np.array_equal(hit, np.isfinite(plane))
        # float32 rounding of two numbers
        np.testing.assert_allclose(plane[hit] * stretch[hit], distance[hit], rtol=1e-6)


def test_every_pixel_of_an_instance_lies_in_its_3d_box(labeled):
    checked = 0
    for view in views(labeled):
        ids, image = instance_ids(view)
        points = world_points(view)
        for path, row in boxes(view, "bounding_box_3d").items():
            inside = points[image == ids.get(path, -1)]
            local = np.concatenate([inside, np.ones((len(inside), 1))], -1) @ np.linalg.inv(row["transform"])
            lower = np.array([row["x_min"], row["y_min"], row["z_min"]])
            upper = np.array([row["x_max"], row["y_max"], row["z_max"]])
            slack = 1e-4 * (upper - lower).max()
            assert np.all(local[:, :3] >= lower - slack)
            assert np.all(local[:, :3] <= upper + slack)
            checked += len(inside)
    assert checked > 500


def test_projected_cuboids_enclose_the_masks_to_within_a_pixel(labeled):
    checked = 0
    for view in views(labeled):
        ids, image = instance_ids(view)
        width, height, focal, world_to_camera = camera(view)
        for path, row in boxes(view, "bounding_box_3d").items():
            corners = np.array(
                [[row[f"{a}_{e}"] for a, e in zip("xyz", ends)] + [1.0] for ends in np.ndindex(2, 2, 2) for ends in
                 [["min" if i == 0 else "max" for i in ends]]]
            )  # fmt: skip
            seen = corners @ row["transform"] @ world_to_camera
            y, x = np.nonzero(image == ids.get(path, -1))
            if len(x) == 0 or np.any(seen[:, 2] > -0.05):
                continue  # points behind the camera have no projection; the test of 3D boxes covers them
            pixels = np.stack(
                [width / 2 - focal * seen[:, 0] / seen[:, 2], height / 2 + focal * seen[:, 1] / seen[:, 2]], 1
            )
            hull = ConvexHull(pixels)
            outside = np.stack([x + 0.5, y + 0.5], 1) @ hull.equations[:, :2].T + hull.equations[:, 2]
            assert outside.max() <= 1.0, path
            checked += 1
    assert checked >= 3


def test_occlusion_is_a_fraction(labeled):
    for view in views(labeled):
        for row in boxes(view, "bounding_box_2d_tight").values():
            assert 0.0 <= row["occlusionRatio"] <= 1.0


@pytest.mark.parametrize("kind", ["rgb", "normals"])
def test_images_have_the_configured_size_and_show_something(labeled, kind):
    for view in views(labeled):
        image = read(view, kind, suffix=".png")
        assert image.shape[:2] == (120, 160)
        assert image.std() > 1
