"""Label AOVs and coverage: exact at pixel centers, and consistent with each other."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance, renderer_of
from usdsdg.errors import RenderError, Unsupported
from usdsdg_render.labels.aov import AOVS
from usdsdg_render.scene.scene import (
    WRAP_BLACK,
    WRAP_CLAMP,
    WRAP_MIRROR,
    WRAP_REPEAT,
    Texture,
    UvTransform,
)

# Value of the instance AOV where nothing is hit.
NO_INSTANCE = -1


def some_scene() -> scenes.Scene:
    rng = np.random.default_rng(5)
    placed = []
    for k in range(12):
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        shape = scenes.cube() if k % 2 else scenes.sphere(rings=12)
        placed.append((shape, scenes.moved(rng.uniform(-2, 2, 3), scale=rng.uniform(0.2, 0.7, 3), rotation=q), 0))
    return scenes.scene_of(placed, dome=scenes.white_dome())


def some_view(**changes):
    values = dict(size=(61, 43), horizontal_aperture_offset=1.5, vertical_aperture_offset=-0.7, meters_per_unit=0.01)
    return scenes.view_from((4, -5, 2), (0.2, 0.1, 0), **{**values, **changes})


def test_every_aov_has_its_shape_dtype_and_miss_value():
    view = some_view()
    labels = renderer_of(some_scene()).labels(view, list(AOVS))
    nothing = labels["instance"] == NO_INSTANCE
    assert 0.1 < nothing.mean() < 0.9
    for name, aov in AOVS.items():
        assert labels[name].shape == (43, 61, *aov.channels)
        assert labels[name].dtype == aov.dtype
        assert (labels[name][nothing] == aov.miss).all()
        assert np.isfinite(labels[name][~nothing]).all()


def test_pixels_unproject_to_their_hit_points():
    view = some_view()
    labels = renderer_of(some_scene()).labels(view, list(AOVS))
    hit = labels["instance"] != NO_INSTANCE
    pixels, depth = view.project(labels["position"][hit])
    rows, columns = np.nonzero(hit)
    np.testing.assert_allclose(pixels, np.stack([columns, rows], -1) + 0.5, atol=1e-3)
    meters = depth * view.meters_per_unit
    np.testing.assert_allclose(labels["distance_to_image_plane"][hit], meters, rtol=1e-5)
    away = np.linalg.norm(labels["position"][hit] - view.local_to_world[3, :3], axis=1)
    np.testing.assert_allclose(labels["distance_to_camera"][hit], away * view.meters_per_unit, rtol=1e-5)


def test_orthographic_pixels_unproject_to_their_hit_points():
    view = some_view(projection_type="orthographic", horizontal_aperture=50.0)
    labels = renderer_of(some_scene()).labels(view, ["instance", "position", "distance_to_image_plane"])
    hit = labels["instance"] != NO_INSTANCE
    assert hit.any()
    pixels, depth = view.project(labels["position"][hit])
    rows, columns = np.nonzero(hit)
    np.testing.assert_allclose(pixels, np.stack([columns, rows], -1) + 0.5, atol=1e-3)
    np.testing.assert_allclose(labels["distance_to_image_plane"][hit], depth * 0.01, rtol=1e-5)


def inside_and_behind() -> tuple:
    """Two orthographic cameras that see the same: one in the middle of the scene, whose near plane is behind it, and
    one that is there.
    """
    values = dict(size=(61, 43), projection_type="orthographic", horizontal_aperture=50.0)
    eye = np.array([0.5, -0.2, 0.1])
    inside = scenes.view_from(eye, eye - (4, -5, 2), clipping_range=(-8.0, 12.0), **values)
    back = inside.local_to_world[2, :3]
    behind = scenes.view_from(eye + 8 * back, eye - (4, -5, 2), clipping_range=(0.0, 20.0), **values)
    return inside, behind


def test_an_orthographic_camera_sees_what_is_behind_it_up_to_its_near_plane():
    inside, behind = inside_and_behind()
    names = ["instance", "position", "distance_to_image_plane", "distance_to_camera"]
    renderer = renderer_of(some_scene())
    labels, expected = renderer.labels(inside, names), renderer.labels(behind, names)
    np.testing.assert_array_equal(labels["instance"], expected["instance"])
    hit = labels["instance"] != NO_INSTANCE
    np.testing.assert_allclose(labels["position"], expected["position"], atol=5e-5)  # float32 of 20 units
    _, depth = inside.project(expected["position"][hit].astype(float))
    assert depth.min() < 0
    for name in names[2:]:
        np.testing.assert_allclose(labels[name][hit], depth, atol=5e-5)
        assert np.isinf(labels[name][~hit]).all()


def test_a_picture_from_within_is_that_of_a_camera_at_the_near_plane():
    inside, behind = inside_and_behind()
    within, expected = (radiance(some_scene(), view, samples=2, bounces=2) for view in (inside, behind))
    # The same paths, but for the rounding of what begins them.
    np.testing.assert_allclose(within.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), rtol=1e-3)
    assert np.isclose(within, expected, rtol=1e-3).all(axis=-1).mean() > 0.99


def test_normals_are_unit_and_face_the_camera():
    view = some_view()
    labels = renderer_of(some_scene()).labels(view, ["instance", "normals", "position"])
    hit = labels["instance"] != NO_INSTANCE
    normals = labels["normals"][hit]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    to_camera = view.local_to_world[3, :3] - labels["position"][hit]
    to_camera /= np.linalg.norm(to_camera, axis=1, keepdims=True)
    # Interpolated normals of a coarse sphere point past its silhouette by up to half a facet.
    assert ((normals * to_camera).sum(1) > -0.2).all()


def test_smooth_normals_of_a_scaled_sphere_follow_the_inverse_transpose():
    scale = np.array([2.0, 1.0, 0.5])
    scene = scenes.scene_of([(scenes.sphere(rings=64), scenes.moved(scale=scale), 0)])
    labels = renderer_of(scene).labels(scenes.view_from((0, -6, 1)), ["instance", "normals", "position"])
    hit = labels["instance"] == 0
    expected = labels["position"][hit] / scale**2
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(labels["normals"][hit], expected, atol=0.01)


def test_normals_of_mirrored_instances_point_outward():
    scene = scenes.scene_of([(scenes.sphere(rings=32), scenes.moved(scale=(-1, 1, 1)), 0)])
    labels = renderer_of(scene).labels(scenes.view_from((0, -6, 1)), ["instance", "normals", "position"])
    hit = labels["instance"] == 0
    assert ((labels["normals"] * labels["position"]).sum(-1)[hit] > 0.9).all()


def test_surfaces_outside_the_clipping_range_are_not_hit():
    scene = scenes.scene_of([(scenes.cube(), scenes.moved(), 0)])
    seen = renderer_of(scene)
    near = seen.labels(scenes.view_from((0, -5, 0), clipping_range=(4.5, 100)), ["instance", "distance_to_image_plane"])
    # The front face, 4 away, is cut off; the back one, 6 away, is seen from inside.
    np.testing.assert_allclose(near["distance_to_image_plane"][12, 16], 6.0, rtol=1e-5)
    far = seen.labels(scenes.view_from((0, -5, 0), clipping_range=(0.1, 3.5)), ["instance"])
    assert (far["instance"] == NO_INSTANCE).all()
    assert seen.coverage(scenes.view_from((0, -5, 0), clipping_range=(0.1, 3.5)), [[0]])[0, 0] == 0


@pytest.mark.parametrize(
    ("lens", "shape"),
    [
        ({}, "wall"),
        ({"projection_type": "orthographic", "horizontal_aperture": 100.0}, "wall"),
        ({"projection_type": "pinholeOpenCV"}, "wall"),
        ({"projection_type": "fisheyeEquidistant"}, "ball"),
        ({"projection_type": "fisheyeSpherical"}, "ball"),
    ],
    ids=["pinhole", "orthographic", "pinholeOpenCV", "fisheye", "panorama"],
)
def test_the_clipping_range_is_planar_for_rectilinear_lenses_and_spherical_for_others(lens, shape):
    """Also at the corners of the image, where distances exceed depths."""
    wall = (scenes.square(), scenes.moved((0, 0, -5), scale=100), 0)
    ball = (scenes.sphere(rings=64), scenes.moved(scale=5), 0)
    renderer = renderer_of(scenes.scene_of([wall if shape == "wall" else ball]))

    def seen(near: float, far: float) -> set[bool]:
        view = scenes.view_from(
            (0, 0, 0), (0, 0, -1), up=(0, 1, 0), clipping_range=(near, far), **{"focal_length": 9.0, **lens}
        )
        shown = renderer.labels(view, ["instance"])["instance"] == 0
        assert shown.any() == (renderer.coverage(view, [[0]])[0, 0] > 0)
        return set(shown.ravel().tolist())

    assert seen(4.95, 100.0) == seen(0.1, 5.05) == {True}
    assert seen(5.05, 100.0) == seen(0.1, 4.95) == {False}


def checker(texels, *, wrap=0, **values):
    """A square in front of the camera showing a texture, and its albedo."""
    texels = np.asarray(texels, np.uint8)
    rgba = np.full((*texels.shape[:2], 4), 255, np.uint8)
    rgba[..., : texels.shape[2]] = texels
    texture = Texture("checker", rgba, values.pop("srgb", False), wrap, wrap, values.pop("transform", UvTransform()))
    matt = scenes.material(base_color_texture=0, **values)
    scene = scenes.scene_of([(scenes.square(), scenes.moved(), 0)], materials=[matt], textures=[texture])
    view = scenes.view_from((0, 0, 5), up=(0, 1, 0), size=(64, 64), focal_length=20.0 * 5 / 2)
    return renderer_of(scene).labels(view, ["albedo"])["albedo"]


RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)


def test_textures_are_upright():
    # Row 0 is at v = 1; the square's v increases upward in the image.
    albedo = checker([[RED, GREEN], [BLUE, WHITE]])
    for (row, column), color in {(16, 16): RED, (16, 47): GREEN, (47, 16): BLUE, (47, 47): WHITE}.items():
        np.testing.assert_allclose(albedo[row, column], np.array(color) / 255, atol=0.05)


def wrapped(index: int, count: int, wrap: int) -> int | None:
    """Texel index for any integer, by wrap mode; None = black."""
    if wrap == WRAP_REPEAT:
        return index % count
    if wrap == WRAP_MIRROR:
        index %= 2 * count
        return index if index < count else 2 * count - 1 - index
    if wrap == WRAP_CLAMP:
        return min(max(index, 0), count - 1)
    return index if 0 <= index < count else None


@pytest.mark.parametrize("wrap", [WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR, WRAP_BLACK])
def test_wrap_modes_match_a_reference_bilinear_look_up(wrap):
    texels = np.random.default_rng(2).integers(0, 256, (3, 4, 3))
    scale, shift = 4.0, -1.6
    albedo = checker(texels, wrap=wrap, transform=UvTransform.of((scale, scale), 0.0, (shift, shift)))
    for row, column in np.random.default_rng(3).integers(0, 64, (60, 2)):
        u, v = (column + 0.5) / 64 * scale + shift, (63.5 - row) / 64 * scale + shift
        x, y = u * 4 - 0.5, (1 - v) * 3 - 0.5
        expected = np.zeros(3)
        for i in (int(np.floor(x)), int(np.floor(x)) + 1):
            for j in (int(np.floor(y)), int(np.floor(y)) + 1):
                at = wrapped(j, 3, wrap), wrapped(i, 4, wrap)
                if None not in at:
                    expected += texels[at] / 255 * (1 - abs(x - i)) * (1 - abs(y - j))
        np.testing.assert_allclose(albedo[row, column], expected, atol=2e-3)


def test_uv_transforms_rotate_and_translate_textures():
    # UsdTransform2d: a quarter turn takes (u, v) to (-v, u); the shift brings it back into the image.
    turned = UvTransform.of((1.0, 1.0), np.pi / 2, (1.0, 0.0))
    albedo = checker([[RED, GREEN], [BLUE, WHITE]], transform=turned)
    # The pixel at (u, v) = (0.75, 0.75), upper right, reads (1 - 0.75, 0.75): upper left.
    np.testing.assert_allclose(albedo[16, 47], np.array(RED) / 255, atol=0.05)
    np.testing.assert_allclose(albedo[16, 16], np.array(BLUE) / 255, atol=0.05)


def test_srgb_textures_are_decoded_exactly():
    albedo = checker(np.full((2, 2, 3), 128), srgb=True)
    np.testing.assert_allclose(albedo[32, 32], ((128 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-5)


def leaf_scene(alpha, **values):
    """A square whose right half has opacity `alpha`, in front of a cube."""
    texels = np.full((2, 2, 4), 255, np.uint8)
    texels[:, 1, 3] = alpha
    texture = Texture("leaf", texels, False, 1, 1)
    leaf = scenes.material(opacity_texture=0, opacity_channel=3, **values)
    placed = [(scenes.square(), scenes.moved((0, 0, 2)), 0), (scenes.cube(), scenes.moved((0, 0, -4), scale=3), 1)]
    return scenes.scene_of(placed, materials=[leaf, scenes.material()], textures=[texture])


@pytest.mark.parametrize(("alpha", "threshold", "behind"), [(0, 0.0, 1), (100, 0.0, 1), (200, 0.0, 0), (200, 0.9, 1)])
def test_labels_see_through_cut_outs(alpha, threshold, behind):
    renderer = renderer_of(leaf_scene(alpha, opacity_threshold=threshold))
    view = scenes.view_from((0, 0, 8), up=(0, 1, 0))
    labels = renderer.labels(view, ["instance"])["instance"]
    assert labels[12, 12] == 0
    assert labels[12, 20] == behind
    assert renderer.coverage(view, [[0], [1], [0, 1]]).tolist() == coverage_one_by_one(
        leaf_scene(alpha, opacity_threshold=threshold), view, [[0], [1], [0, 1]]
    )


def coverage_one_by_one(scene, view, groups) -> list[list[int]]:
    """Coverage from label passes of scenes with one group alone."""
    rows = []
    everything = scene.instances
    for group in groups:
        scene.instances = type(everything)(
            tuple(everything.paths[k] for k in group),
            everything.prototype[group],
            everything.local_to_world[group],
            everything.slot_offset[group],
            everything.casts_shadow[group],
        )
        scene.touch("instances", "transforms")
        alone = renderer_of(scene).labels(view, ["instance"])["instance"] >= 0
        y, x = np.nonzero(alone)
        box = [x.min(), y.min(), x.max(), y.max()] if len(x) else [-1] * 4
        rows.append([int(alone.sum()), *map(int, box)])
    scene.instances = everything
    return rows


@pytest.mark.parametrize("projection", ["pinhole", "orthographic"])
def test_coverage_is_what_a_group_covers_alone(projection):
    view = some_view(projection_type=projection, horizontal_aperture=20.0 if projection == "pinhole" else 50.0)
    groups = [[k] for k in range(12)] + [[0, 3, 7], [], list(range(12))]
    renderer = renderer_of(some_scene())
    coverage = renderer.coverage(view, groups)
    assert coverage.tolist() == coverage_one_by_one(some_scene(), view, groups)
    visible = np.bincount(renderer.labels(view, ["instance"])["instance"].ravel() + 1, minlength=13)[1:]
    assert (coverage[:12, 0] >= visible).all()
    assert (coverage[:12, 0] > visible).any()
    assert coverage[14, 0] == visible.sum()


def test_coverage_with_the_camera_inside_and_in_front_of_objects():
    scene = scenes.scene_of(
        [(scenes.sphere(rings=8), scenes.moved(scale=3), 0), (scenes.cube(), scenes.moved((0, 50, 0)), 0)]
    )
    view = scenes.view_from((0, -1, 0))
    groups = [[0], [1]]
    coverage = renderer_of(scene).coverage(view, groups)
    assert coverage.tolist() == coverage_one_by_one(scene, view, groups)
    assert coverage[0, 0] == 32 * 24


def test_motion_vectors_point_to_the_previous_pixel():
    scene = scenes.scene_of(
        [(scenes.cube(), scenes.moved(), 0), (scenes.cube(), scenes.moved((0, 50, 0), scale=40), 0)]
    )
    renderer = renderer_of(scene)
    view = scenes.view_from((0, -10, 0))
    first = renderer.labels(view, ["motion_vectors"])["motion_vectors"]
    assert (first == 0).all()
    # The cube moves right and up; the wall stands still.
    scene.instances.local_to_world[0, 3, :3] = (0.5, 0, 0.25)
    scene.touch("transforms")
    renderer.sync()
    labels = renderer.labels(view, ["motion_vectors", "instance", "position"])
    moved = labels["instance"] == 0
    assert (labels["motion_vectors"][~moved] == 0).all()
    now, _ = view.project(labels["position"][moved])
    before, _ = view.project(labels["position"][moved] - (0.5, 0, 0.25))
    np.testing.assert_allclose(labels["motion_vectors"][moved], before - now, atol=1e-3)
    assert (labels["motion_vectors"][moved][:, 0] < 0).all()
    assert (labels["motion_vectors"][moved][:, 1] > 0).all()
    # Then the camera moves left, without a sync between: everything moves right in the image, the near cube more.
    labels = renderer.labels(scenes.view_from((-0.3, -10, 0), (-0.3, 0, 0)), ["motion_vectors", "instance"])
    cube, wall = (labels["motion_vectors"][labels["instance"] == k][:, 0].mean() for k in (0, 1))
    assert cube < wall < 0


def test_empty_scenes_and_invalid_requests():
    empty = renderer_of(scenes.scene_of([]))
    one = scenes.view_from((0, 0, 5), size=(1, 1))
    assert empty.labels(one, ["instance"])["instance"].tolist() == [[NO_INSTANCE]]
    assert empty.coverage(one, []).shape == (0, 5)
    assert empty.coverage(one, [[]]).tolist() == [[0, -1, -1, -1, -1]]
    with pytest.raises(RenderError, match="no such AOV: depht"):
        empty.labels(one, ["depht"])
    with pytest.raises(Unsupported, match="projection 'wide' is not available"):
        empty.labels(scenes.view_from((0, 0, 5), projection_type="wide"), ["instance"])


def test_translucent_surfaces_transmit_by_opacity():
    # Two emissive squares of opacity 0.3 before an emissive wall: radiance is composited layer by layer.
    veil = scenes.material(base_color=0.0, specular=0.0, emission=10.0, opacity=0.3)
    wall = scenes.material(base_color=0.0, specular=0.0, emission=100.0)
    placed = [
        (scenes.square(), scenes.moved((0, 0, 1), scale=9), 0),
        (scenes.square(), scenes.moved((0, 0, 2), scale=9), 0),
        (scenes.square(), scenes.moved(scale=9), 1),
    ]
    scene = scenes.scene_of(placed, materials=[veil, wall])
    view = scenes.view_from((0, 0, 8), up=(0, 1, 0), size=(8, 8))
    expected = 10 * 0.3 + 0.7 * (10 * 0.3 + 0.7 * 100)
    image = radiance(scene, view, samples=64)
    np.testing.assert_allclose(image.mean(), expected, rtol=0.01)
    # Stratified samples leave little noise in each pixel.
    np.testing.assert_allclose(image, expected, rtol=0.1)
    # Labels count it as opaque, and its shadow is as dark as its opacity.
    assert (renderer_of(scene).labels(view, ["instance"])["instance"] == 1).all()
    lit = scenes.scene_of(
        [(scenes.square(), scenes.moved((0, 0, 9), scale=50), 0), (scenes.square(), scenes.moved(scale=50), 1)],
        materials=[scenes.material(opacity=0.3), scenes.material(base_color=1.0, specular=0.0)],
        lights=[scenes.distant_light(np.pi)],
    )
    shadowed = radiance(lit, view, samples=16, bounces=1)
    np.testing.assert_allclose(shadowed.mean(), 0.7, rtol=0.01)


def test_material_aovs_of_the_visible_surface():
    rng = np.random.default_rng(3)
    rgba = rng.integers(0, 256, (4, 4, 4), np.uint8)
    rgba[..., 3] = 255
    texture = Texture("rough", rgba, False, WRAP_REPEAT, WRAP_REPEAT)
    made = scenes.material(
        base_color=(0.8, 0.4, 0.2), metallic=0.25, roughness=0.5, roughness_texture=0, roughness_channel=1,
        specular=(0.04, 0.05, 0.06), emission=(3.0, 2.0, 1.0),
    )  # fmt: skip
    scene = scenes.scene_of([(scenes.square(), scenes.moved(), 0)], materials=[made], textures=[texture])
    view = scenes.view_from((0, 0, 5), up=(0, 1, 0), size=(64, 64), focal_length=20.0 * 5 / 2)
    names = ["instance", "diffuse", "specular", "roughness", "emission", "albedo"]
    labels = renderer_of(scene).labels(view, names)
    seen = labels["instance"] == 0
    base = np.array([0.8, 0.4, 0.2])
    np.testing.assert_allclose(labels["albedo"][seen], np.broadcast_to(base, (seen.sum(), 3)), rtol=1e-5)
    np.testing.assert_allclose(labels["diffuse"][seen] - 0.75 * base, 0, atol=1e-6)
    f0 = 0.75 * np.array([0.04, 0.05, 0.06]) + 0.25 * base
    np.testing.assert_allclose(labels["specular"][seen] - f0, 0, atol=1e-6)
    np.testing.assert_allclose(labels["emission"][seen] - (3, 2, 1), 0, atol=1e-6)
    # Texel centers, an eighth of the square from its edges; row 0 is at the top.
    middles = labels["roughness"][8::16, 8::16]
    np.testing.assert_allclose(middles, 0.5 * rgba[..., 1] / 255, atol=0.5 / 16)


def test_normal_maps_change_bump_normals_only():
    rgba = np.full((1, 1, 4), 255, np.uint8)
    rgba[0, 0, :3] = (204, 128, 230)  # +0.6 along u, 0 along v, 0.8 up
    texture = Texture("bump", rgba, False, WRAP_REPEAT, WRAP_REPEAT)
    made = scenes.material(normal_texture=0, normal_scale=1.0)
    scene = scenes.scene_of([(scenes.square(), scenes.moved(), 0)], materials=[made], textures=[texture])
    labels = renderer_of(scene).labels(
        scenes.view_from((0, 0, 5), up=(0, 1, 0)), ["instance", "normals", "bump_normals"]
    )
    seen = labels["instance"] == 0
    np.testing.assert_allclose(labels["normals"][seen] - (0, 0, 1), 0, atol=1e-6)
    # Bytes are 1/255 apart.
    np.testing.assert_allclose(labels["bump_normals"][seen] - (0.6, 0, 0.8), 0, atol=0.01)
    plain = scenes.scene_of([(scenes.sphere(), scenes.moved(), 0)])
    labels = renderer_of(plain).labels(some_view(), ["normals", "bump_normals"])
    np.testing.assert_array_equal(labels["normals"], labels["bump_normals"])


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("size", [1e2, 1e4, 1e6, 1e7])
def test_depths_of_a_large_floor_are_those_of_its_plane(size, rotated):
    """A camera 1.5 units above a floor of up to 10,000 km, of which single precision would lose the depth."""
    floor = scenes.square()
    floor = scenes.prototype(floor.points * np.float32(size), floor.triangles)
    q, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    rotation = q * np.sign(np.linalg.det(q)) if rotated else np.eye(3)
    eye, target = (0.3, 0.2, 1.5) @ rotation, (1.3, 0.2, 1.0) @ rotation
    view = scenes.view_from(eye, target, size=(48, 48), clipping_range=(0.01, 1e9))
    scene = scenes.scene_of([(floor, scenes.moved((0, 0, 0), rotation=rotation.T), 0)])
    labels = renderer_of(scene).labels(view, ["distance_to_camera", "distance_to_image_plane", "position"])
    rows, columns = np.mgrid[:48, :48] + 0.5
    _, directions = view.rays(np.stack([columns.ravel(), rows.ravel()], -1))
    directions = directions @ view.local_to_world[:3, :3]
    normal = rotation[2]
    with np.errstate(divide="ignore"):
        expected = (view.local_to_world[3, :3] @ normal) / -(directions @ normal)
    points = view.local_to_world[3, :3] + expected[:, None] * directions
    onto = (expected > 0) & (np.abs(points @ rotation.T)[:, :2] < size).all(1)
    assert onto.mean() > 0.5
    found = labels["distance_to_camera"].ravel()
    assert (np.isfinite(found) == onto).all()
    # At grazing angles the direction's own rounding counts as much more as the ray is longer than its height.
    tolerance = 2e-6 * np.maximum(expected[onto], 1.0) * expected[onto]
    assert (np.abs(found[onto] - expected[onto]) < tolerance).all()
    aside = np.linalg.norm(labels["position"].reshape(-1, 3)[onto] - points[onto], axis=1)
    assert (aside < 2 * tolerance + 1e-5 * expected[onto]).all()
    depth = view.project(points[onto])[1]
    assert (np.abs(labels["distance_to_image_plane"].ravel()[onto] - depth) < tolerance).all()
