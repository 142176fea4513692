"""Batches of many images: the labels of each are those of the image rendered alone."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import renderer_of
from tests.render.labels.test_label_pass import some_scene, some_view
from tests.stage.cameras.lens_cases import CASES
from usdsdg.errors import RenderError
from usdsdg_render.device import view_batches
from usdsdg_render.labels.aov import AOVS


def camera(name: str, eye, **values):
    view = scenes.view_from(eye, **values)
    return type(view)(**{**vars(view), "prim_path": name})


def cameras() -> list:
    """Views of several sizes, with heights that are no multiples of bands, and a lens."""
    views = [camera(f"/c{k}", (5 * np.cos(k), 5 * np.sin(k), 1), size=(37, 30)) for k in range(3)]
    views.insert(1, camera("/small", (4, 0, 0), size=(16, 9)))
    views += [camera("/fish", (4, 1, 0), size=(37, 30), **CASES["fisheyePolynomial by default"])]
    return views


def assert_same(ours: dict, theirs: dict) -> None:
    assert ours.keys() == theirs.keys()
    for name in ours:
        np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)


@pytest.mark.parametrize("pixels", [1 << 24, 2500], ids=["in one launch", "in several"])
def test_labels_of_many_views_are_those_of_each(pixels, monkeypatch):
    monkeypatch.setattr(view_batches, "LABEL_PIXELS", pixels)
    scene, views = some_scene(), cameras()
    together, alone = renderer_of(scene), renderer_of(scene)
    for step in range(2):
        scene.instances.local_to_world[:, 3, 0] += 0.1 * step
        scene.touch("transforms")
        together.sync(), alone.sync()
        rendered = together.labels_of(views, list(AOVS))
        assert [each["instance"].shape for each in rendered] == [(view.height, view.width) for view in views]
        for view, labels in zip(views, rendered, strict=True):
            assert_same(labels, alone.labels(view, list(AOVS)))
    assert all((labels["motion_vectors"] != 0).any() for labels in rendered)


def test_boxes_and_masks_are_those_of_the_pixels():
    scene = some_scene()
    views = [camera(f"/c{k}", (5 * np.cos(k), 5 * np.sin(k), 1), size=(150, 40)) for k in range(4)]
    renderer = renderer_of(scene)
    batch = renderer.label_batch(views, ["instance"])
    boxes = batch.boxes(len(renderer.gprims))
    masks = batch.masks(np.arange(100, 112), nothing=7).numpy()
    assert boxes.shape == (4, 12, 5)
    for image, labels in enumerate(batch.numpy()):
        shown = labels["instance"]
        np.testing.assert_array_equal(masks[image], np.where(shown >= 0, shown + 100, 7))
        for gprim in range(12):
            y, x = np.nonzero(shown == gprim)
            expected = [len(x), x.min(), y.min(), x.max(), y.max()] if len(x) else [0, -1, -1, -1, -1]
            assert boxes[image, gprim].tolist() == expected
    assert (boxes[..., 0] == 0).any()
    np.testing.assert_array_equal(batch.boxes(3), boxes[:, :3])


def test_motion_is_kept_for_each_image_size_of_a_camera():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    renderer = renderer_of(scene)
    large, small = (scenes.view_from((0, -10, 0), size=size) for size in ((64, 48), (16, 12)))
    renderer.labels_of([large, small], ["motion_vectors"])
    scene.instances.local_to_world[0, 3, 0] = 1.0
    scene.touch("transforms")
    renderer.sync()
    moved = []
    for view in (large, small, large):  # asked again, the answer is the same
        labels = renderer.labels(view, ["motion_vectors", "instance", "position"])
        met = labels["instance"] == 0
        now, _ = view.project(labels["position"][met])
        before, _ = view.project(labels["position"][met] - (1.0, 0, 0))
        np.testing.assert_allclose(labels["motion_vectors"][met], before - now, atol=1e-3)
        moved.append(labels["motion_vectors"])
    np.testing.assert_array_equal(moved[0], moved[2])
    assert np.abs(moved[0]).max() > 2 * np.abs(moved[1]).max()
    renderer.sync()
    assert (renderer.labels(large, ["motion_vectors"])["motion_vectors"] == 0).all()


def test_empty_and_mixed_batches():
    renderer = renderer_of(scenes.scene_of([]))
    views = cameras()
    assert renderer.labels_of([], ["instance"]) == []
    assert renderer.labels_of(views[:2], []) == [{}, {}]
    assert all((labels["motion_vectors"] == 0).all() for labels in renderer.labels_of(views[:1], ["motion_vectors"]))
    assert renderer.label_batch(views[:1], ["instance"]).boxes(0).shape == (1, 0, 5)
    with pytest.raises(RenderError, match="16x9, 37x30"):
        renderer.label_batch(views, ["instance"])
    with pytest.raises(RenderError, match="these are none"):
        renderer.label_batch([], ["instance"])
    with pytest.raises(RenderError, match="no such AOV"):
        renderer.labels_of([some_view()], ["depht"])
