"""Motion vectors: the position of each hit point in the previous image, minus its current one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, Vt

from tests.render import scenes
from tests.render.images import renderer_of
from tests.render.test_lenses import EXACT, SIZE, centers, inside, rays_in_world
from tests.sampled_cases import sampled
from tests.stage.cameras.lens_cases import LENSES
from tests.stage.geometry.characters import add_character
from usdsdg_render.renderer import WarpRenderer

NAMES = ["instance", "prim", "barycentrics", "position", "motion_vectors"]


def turned(axis, degrees, translation=(0, 0, 0), scale=1.0) -> np.ndarray:
    rotation = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*axis), degrees))).T
    return scenes.moved(translation, scale=scale, rotation=rotation)


@pytest.mark.parametrize(
    "projection",
    [{}, {"projection_type": "orthographic", "horizontal_aperture": 60.0}],
    ids=["pinhole", "orthographic"],
)
def test_of_objects_that_rotate_scale_and_move_under_a_moving_camera(projection):
    before = [turned((1, 2, 3), 10, (-1, 0, 0)), turned((0, 0, 1), 0, (1, 0.5, 0), 0.7)]
    after = [turned((1, 2, 3), 35, (-0.8, 0.2, 0.1)), turned((3, 1, 0), 20, (1.1, 0.3, 0.2), (0.9, 0.6, 0.8))]
    scene = scenes.scene_of([(scenes.cube(), before[0], 0), (scenes.sphere(rings=9), before[1], 0)])
    renderer = renderer_of(scene)
    first = scenes.view_from((1, -8, 3), size=(70, 50), horizontal_aperture_offset=1.0, **projection)
    second = scenes.view_from(
        (0.5, -7, 3.5), (0.2, 0, 0.1), size=(70, 50), horizontal_aperture_offset=1.0, **projection
    )
    renderer.labels(first, ["motion_vectors"])
    scene.instances.local_to_world[:] = after
    scene.touch("transforms")
    renderer.sync()
    labels = renderer.labels(second, NAMES)
    for k, matrix in enumerate(before):
        mine = labels["instance"] == k
        assert mine.sum() > 100
        prototype = scene.prototypes[k]
        corners = prototype.points[prototype.triangles[labels["prim"][mine]]].astype(np.float64)
        local = np.einsum("nk,nkj->nj", labels["barycentrics"][mine], corners)
        was, _ = first.project(local @ matrix[:3, :3] + matrix[3, :3])
        rows, columns = np.nonzero(mine)
        moved = was - np.stack([columns, rows], -1) - 0.5
        np.testing.assert_allclose(labels["motion_vectors"][mine], moved, atol=2e-3)
    # Points at infinity move only with the camera's rotation; an orthographic camera shows none of it.
    far = labels["instance"] < 0
    rows, columns = np.nonzero(far)
    if projection:
        assert not labels["motion_vectors"][far].any()
        return
    directions = np.stack([columns + 0.5 - second.cx, second.cy - rows - 0.5, np.full(len(rows), -second.fx)], -1)
    directions = directions @ second.local_to_world[:3, :3]
    was, _ = first.project(first.local_to_world[3, :3] + 1e6 * directions)
    moved = was - np.stack([columns, rows], -1) - 0.5
    np.testing.assert_allclose(labels["motion_vectors"][far], moved, atol=2e-3)


def test_new_instances_have_no_motion():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0), (scenes.cube(), scenes.moved((3, 0, 0)), 0)])
    renderer = renderer_of(scene)
    view = scenes.view_from((0, -12, 0))
    renderer.labels(view, ["motion_vectors"])
    scene.instances.local_to_world[:, 3, 2] += 0.5
    scene.instances.paths = (scene.instances.paths[0], "/World/new")
    scene.touch("instances", "transforms")
    renderer.sync()
    labels = renderer.labels(view, NAMES)
    assert (labels["motion_vectors"][labels["instance"] == 0][:, 1] > 1).all()
    assert not labels["motion_vectors"][labels["instance"] == 1].any()


def test_motion_is_relative_to_the_last_frame_of_each_camera():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    renderer = renderer_of(scene)
    views = [replace(scenes.view_from((x, -9, 1)), prim_path=f"/World/camera_{x}") for x in (0, 1, 2)]

    def move() -> None:
        scene.instances.local_to_world[0, 3, :3] += (0.3, 0.0, 0.1)
        scene.touch("transforms")
        renderer.sync()

    for view in views[:2]:  # one after the other; the last camera rendered none
        renderer.labels(view, ["motion_vectors"])
        move()
    rendered = renderer.labels_of(views, NAMES)
    for view, labels, steps in zip(views, rendered, (2, 1, 0), strict=True):
        mine = labels["instance"] == 0
        expected = displacement(labels, mine, view, labels["position"][mine] - np.array((0.3, 0.0, 0.1)) * steps)
        np.testing.assert_allclose(labels["motion_vectors"][mine], expected, atol=2e-3)


def displacement(labels, mine, view, before: np.ndarray) -> np.ndarray:
    """Expected motion of pixels, (N, 2), from the previous world positions (N, 3) of their points."""
    rows, columns = np.nonzero(mine)
    return view.project(before)[0] - np.stack([columns, rows], -1) - 0.5


def test_of_a_mesh_with_time_sampled_points():
    # A wavy sheet under an affine map, which holds between vertices as well.
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Sheet")
    x, y = np.meshgrid(np.linspace(-1, 1, 7), np.linspace(-1, 1, 7), indexing="ij")
    points = np.stack([x, y, 0.2 * np.sin(3 * x + y)], -1).reshape(-1, 3)
    quads = [(7 * i + j, 7 * i + j + 7, 7 * i + j + 8, 7 * i + j + 1) for i in range(6) for j in range(6)]
    mesh.CreateFaceVertexCountsAttr([4] * len(quads))
    mesh.CreateFaceVertexIndicesAttr([k for quad in quads for k in quad])
    mesh.CreateSubdivisionSchemeAttr("none")
    bend, shift = np.array([[1.1, 0.2, 0], [-0.1, 0.9, 0.1], [0, 0.3, 1.2]]), np.array([0.1, -0.2, 0.3])
    for code, values in ((0, points), (1, points @ bend + shift)):
        mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(values.astype(np.float32)), code)
    move = mesh.AddTranslateOp()
    move.Set(Gf.Vec3d(0, 0, 0), 0)
    move.Set(Gf.Vec3d(0.2, 0.1, 0), 1)
    renderer = WarpRenderer(stage, device="cpu")
    view = scenes.view_from((1, -2, 6), size=(60, 50))
    renderer.sync(Usd.TimeCode(0))
    renderer.labels(view, ["motion_vectors"])
    renderer.sync(Usd.TimeCode(1))
    labels = renderer.labels(view, NAMES)
    mine = labels["instance"] == 0
    assert mine.sum() > 300
    was = (labels["position"][mine].astype(np.float64) - (0.2, 0.1, 0) - shift) @ np.linalg.inv(bend)
    expected = displacement(labels, mine, view, was)
    assert np.abs(expected).max() > 2
    np.testing.assert_allclose(labels["motion_vectors"][mine], expected, atol=3e-3)
    # Without a change there is no motion.
    renderer.sync()
    assert np.abs(renderer.labels(view, NAMES)["motion_vectors"]).max() < 1e-3


@pytest.mark.parametrize("lens", [{}, {"projection_type": "fisheyeEquidistant"}], ids=["pinhole", "fisheye"])
def test_of_a_skinned_mesh(lens):
    stage = Usd.Stage.CreateInMemory()
    add_character(stage, "/Man")
    UsdGeom.SetStageUpAxis(stage, "Z")
    renderer = WarpRenderer(stage, device="cpu")
    view = scenes.view_from((5, -4, 2), (0, 0, 0.8), size=(80, 60), **lens)
    prototypes = []
    for code in (6, 12):
        renderer.sync(Usd.TimeCode(code))
        scene = renderer._scene
        prototypes.append(scene.prototypes[scene.instances.prototype[0]])
        labels = renderer.labels(view, NAMES)
    before, now = prototypes
    assert not np.allclose(before.points, now.points)
    mine = labels["instance"] == 0
    # The triangle of each pixel, among those of its face, is the one whose barycentrics reproduce the point.
    was = np.zeros((mine.sum(), 3))
    for k, (face, weights, position) in enumerate(
        zip(labels["prim"][mine], labels["barycentrics"][mine], labels["position"][mine], strict=True)
    ):
        triangles = np.flatnonzero(now.triangle_faces == face)
        points = np.einsum("k,tkj->tj", weights, now.points[now.triangles[triangles]])
        found = np.abs(points - position).max(1).argmin()
        np.testing.assert_allclose(points[found], position, atol=1e-4)
        was[k] = weights @ before.points[before.triangles[triangles[found]]]
    expected = displacement(labels, mine, view, was)
    assert mine.sum() > 200
    assert np.abs(expected).max() > 1
    np.testing.assert_allclose(labels["motion_vectors"][mine], expected, atol=5e-3)


def test_of_a_mesh_with_a_new_topology_is_the_motion_of_its_prim():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    renderer = renderer_of(scene)
    view = scenes.view_from((0, -8, 0))
    renderer.labels(view, ["motion_vectors"])
    scene.prototypes = [scenes.sphere(rings=8)]
    scene.instances.local_to_world[0, 3, :3] = (0.5, 0, 0)
    scene.touch("prototypes", "instances", "transforms")
    renderer.sync()
    labels = renderer.labels(view, NAMES)
    mine = labels["instance"] == 0
    expected = displacement(labels, mine, view, labels["position"][mine] - (0.5, 0, 0))
    np.testing.assert_allclose(labels["motion_vectors"][mine], expected, atol=2e-3)


@pytest.mark.parametrize("case", sampled(LENSES.values(), 5), ids=sampled(LENSES, 5))
def test_points_at_infinity_move_with_the_rotation_of_a_lens(case):
    renderer = renderer_of(scenes.scene_of([], dome=scenes.white_dome()))
    before = inside(case)
    renderer.labels(before, ["motion_vectors"])
    now = replace(before, local_to_world=scenes.view_from((3.0, 1.0, 0.0), (0.0, -2.3, 0.5)).local_to_world)
    motion = renderer.labels(now, ["motion_vectors"])["motion_vectors"].reshape(-1, 2)
    _, directions = rays_in_world(now)
    moved = before.project(1e7 * directions + before.local_to_world[3, :3])[0] - centers()
    error = moved - motion
    error[:, 0] -= SIZE[0] * np.round(error[:, 0] / SIZE[0])  # panoramas wrap around
    is_known, is_reported = np.isfinite(moved).all(axis=1), motion.any(axis=1)
    # Single and double precision may disagree only at the edge of the field of view.
    assert (is_known & ~is_reported).mean() < 0.01
    assert (is_known & is_reported).mean() > 0.3
    assert np.abs(motion).max() > 10
    assert np.quantile(np.abs(error[is_known & is_reported]), 0.99) < 5 * EXACT
