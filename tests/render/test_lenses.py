"""Images and labels through every lens: kernels against the NumPy models and the analytic hits of a room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import renderer_of
from tests.render.labels.test_label_pass import NO_INSTANCE, coverage_one_by_one, some_scene
from tests.sampled_cases import sampled
from tests.stage.cameras.lens_cases import CASES, LENSES, PANORAMAS
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.labels.aov import AOVS
from usdsdg_render.labels.lens_bounds import bound_through_lens
from usdsdg_render.settings import PathSettings

EYE, TARGET = (1.0, 2.0, 0.5), (0.0, 0.3, 0.2)
SIZE = (161, 101)
# Half extents of the room.
ROOM = np.array([5.0, 6.0, 4.0])
# Pixels: the kernels compute in single precision.
EXACT = 5e-4


def inside(case: dict, *, size=SIZE, **changes) -> CameraView:
    return scenes.view_from(EYE, TARGET, size=size, **{"focal_length": 12.0, **case, **changes})


def room(**values) -> scenes.Scene:
    return scenes.scene_of([(scenes.cube(), scenes.moved(scale=ROOM), 0)], dome=scenes.white_dome(), **values)


def centers(size=SIZE) -> np.ndarray:
    y, x = np.mgrid[: size[1], : size[0]] + 0.5
    return np.stack([x, y], axis=-1).reshape(-1, 2)


def rays_in_world(view: CameraView) -> tuple[np.ndarray, np.ndarray]:
    origins, directions = view.rays(centers((view.width, view.height)))
    turn = view.local_to_world[:3, :3]
    return origins @ turn + view.local_to_world[3, :3], directions @ turn


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_depth_times_the_ray_of_a_pixel_is_its_hit_point(case):
    view = inside(case, meters_per_unit=0.01)
    labels = renderer_of(room()).labels(view, list(AOVS))
    origins, directions = rays_in_world(view)
    hit = labels["instance"].ravel() == 0
    # Single and double precision may disagree only at the edge of the field of view.
    assert (hit != np.isfinite(directions).all(axis=1)).sum() <= 0.001 * hit.size
    assert hit.mean() > 0.4
    hit &= np.isfinite(directions).all(axis=1)
    points = labels["position"].reshape(-1, 3)[hit]
    # The first wall that the ray hits, in double precision.
    with np.errstate(divide="ignore"):
        walls = (np.sign(directions[hit]) * ROOM - origins[hit]) / directions[hit]
    distance = walls.min(axis=1, keepdims=True)
    np.testing.assert_allclose(points, origins[hit] + distance * directions[hit], atol=2e-4)
    along = labels["distance_to_camera"].ravel()[hit] * 100
    np.testing.assert_allclose(along, distance[:, 0], rtol=2e-5)
    np.testing.assert_allclose(origins[hit] + along[:, None] * directions[hit], points, atol=2e-4)
    pixels, depth = view.project(points)
    to_plane = labels["distance_to_image_plane"].ravel()[hit]
    np.testing.assert_allclose(to_plane, depth / 100, rtol=2e-5, atol=2e-6)
    error = np.abs(pixels - centers()[hit])
    if case.get("projection_type") in PANORAMAS:
        assert view.lens is not None
        # Columns converge at the poles, and rays of a stereo eye are tangent to its circle.
        level = np.sin(np.pi * centers()[hit, 1] / view.height)
        error[:, 0] *= level
        error[:, 1] *= along * level / (along * level + abs(view.lens.eye_offset))
    assert error.max() < EXACT


@pytest.mark.parametrize("case", sampled(LENSES.values(), 4), ids=sampled(LENSES, 4))
def test_pixels_outside_the_field_of_view_are_empty(case):
    # Wide enough for every lens but a panorama and OpenCV's mild one to leave corners.
    view = inside(case, horizontal_aperture=90.0)
    renderer = renderer_of(room())
    renderer.labels(view, ["motion_vectors"])
    labels = renderer.labels(view, list(AOVS))
    outside = labels["instance"] == NO_INSTANCE
    for name, aov in AOVS.items():
        assert (labels[name][outside] == aov.miss).all(), name
    film = renderer.new_film(*SIZE)
    renderer.accumulate(film, view, samples=4, settings=PathSettings(denoise=True))
    image = renderer.develop(film)
    # The dome and the room are bright; only pixels without any valid sample are transparent.
    clear = image["LdrColor"][..., 3] == 0
    assert not image["LdrColor"][clear].any()
    assert not image["HdrColor"][clear].any()
    assert not clear[~outside].any()
    assert (clear | ~outside).mean() > 0.97
    assert (image["LdrColor"][~clear][:, 3] == 255).all()


def test_the_field_of_view_of_a_fisheye_is_a_circle():
    view = inside({"projection_type": "fisheyePolynomial"}, size=(242, 152))
    seen = renderer_of(room()).labels(view, ["instance"])["instance"] == 0
    # 100 degrees at 0.00245 radians per pixel of 1936.
    radius = np.radians(100.0) / 0.00245 / 8
    away = np.linalg.norm(centers((242, 152)) - np.array([970.94244, 600.37482]) / 8, axis=1).reshape(seen.shape)
    assert seen[away < radius - 1e-3].all()
    assert not seen[away > radius + 1e-3].any()


@pytest.mark.parametrize("case", sampled(LENSES.values(), 5), ids=sampled(LENSES, 5))
def test_coverage_is_what_a_group_covers_alone(case):
    view = scenes.view_from((0.1, -0.1, 0.2), (1, 0, 0), size=(61, 43), **{"focal_length": 12.0, **case})
    groups = [[k] for k in range(12)] + [[0, 3, 7], [], list(range(12))]
    coverage = renderer_of(some_scene()).coverage(view, groups)
    assert coverage.tolist() == coverage_one_by_one(some_scene(), view, groups)
    assert (coverage[:, 0] > 0).sum() > 3


@pytest.mark.parametrize("case", sampled(LENSES.values(), 5), ids=sampled(LENSES, 5))
def test_boxes_outside_the_image_have_no_bounds(case):
    view = inside(case)
    lens = view.lens
    assert lens is not None
    if lens.curve is None or lens.model == "fisheyeEquidistant":
        return
    behind = view.local_to_world[3, :3] + 50 * view.local_to_world[2, :3]
    ahead = view.local_to_world[3, :3] - 50 * view.local_to_world[2, :3]
    boxes = bound_through_lens(view, np.array([behind, ahead]) - 1.0, np.array([behind, ahead]) + 1.0)
    assert boxes[0].tolist() == [0, 0, 0, 0]
    area = np.prod(boxes[1, 2:] - boxes[1, :2])
    assert 0 < area < 0.5 * SIZE[0] * SIZE[1]


@pytest.mark.parametrize("case", LENSES.values(), ids=LENSES)
def test_motion_vectors_are_the_displacement_of_the_projected_point(case):
    ball = scenes.sphere(rings=24)
    scene = scenes.scene_of(
        [(ball, scenes.moved(scale=0.3), 0), (scenes.cube(), scenes.moved(scale=ROOM), 0)], dome=scenes.white_dome()
    )
    renderer = renderer_of(scene)
    view = inside(case)
    assert not renderer.labels(view, ["motion_vectors"])["motion_vectors"].any()
    assert np.abs(renderer.labels(view, ["motion_vectors"])["motion_vectors"]).max() < EXACT
    scene.instances.local_to_world[0, 3, :3] += (0.2, 0.1, -0.15)
    scene.touch("instances")
    renderer.sync()
    now = replace(view, local_to_world=scenes.view_from((1.1, 1.9, 0.55), TARGET).local_to_world)
    labels = renderer.labels(now, ["motion_vectors", "instance", "position"])
    for index, step in ((0, (0.2, 0.1, -0.15)), (1, (0.0, 0.0, 0.0))):
        mine = (labels["instance"] == index) & labels["motion_vectors"].any(axis=-1)
        assert mine.any()
        points = labels["position"][mine]
        moved = view.project(points - np.array(step))[0] - now.project(points)[0]
        if case.get("projection_type") in PANORAMAS:
            moved[:, 0] -= SIZE[0] * np.round(moved[:, 0] / SIZE[0])
        known = np.isfinite(moved).all(axis=1)
        assert known.mean() > 0.99
        error = np.abs(moved - labels["motion_vectors"][mine])[known]
        # At the edge of a lens and at the poles of panoramas, small rounding errors are many pixels.
        assert np.quantile(error, 0.99) < 5 * EXACT


def test_a_fisheye_is_sharp_at_its_focus_distance_only():
    # A bright wall with a black square at its center, seen through an aperture of 2 units.
    def edge_width(focus: float) -> float:
        black, white = (
            scenes.material(base_color=0.0, specular=0.0),
            scenes.material(base_color=0.0, specular=0.0, emission=1.0),
        )
        scene = scenes.scene_of(
            [
                (scenes.square(), scenes.moved((0, 0, -9.9)), 0),
                (scenes.square(), scenes.moved((0, 0, -10), scale=40), 1),
            ],
            materials=[black, white],
        )
        view = scenes.view_from(
            (0, 0, 0), (0, 0, -1), up=(0, 1, 0), size=(81, 81), projection_type="fisheyeEquidistant",
            focal_length=50.0, f_stop=2.5, focus_distance=focus,
        )  # fmt: skip
        renderer = renderer_of(scene)
        film = renderer.new_film(81, 81)
        renderer.accumulate(film, view, samples=64, settings=PathSettings(denoise=False))
        row = film.radiance()[40, :, 0]
        return float(((row > 0.05) & (row < 0.95)).sum())

    assert edge_width(10.0) <= 4 < edge_width(4.0)
