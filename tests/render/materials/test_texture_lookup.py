"""Textures as surfaces show them: precision, tiles, transforms of their own, and the layers that they drive."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import radiance
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.scene import WRAP_CLAMP, WRAP_REPEAT, Texture, UvTransform

SIZE = 64


def card_with(textures, **values):
    """A renderer of the unit square of texture coordinates, which fills the image, and a view of it."""
    scene = scenes.scene_of(
        [(scenes.square(), scenes.moved(), 0)],
        materials=[scenes.material(**values)],
        textures=textures,
        dome=scenes.white_dome(),
    )
    view = scenes.view_from((0, 0, 5), up=(0, 1, 0), size=(SIZE, SIZE), focal_length=20.0 * 5 / 2)
    return WarpRenderer.of_scene(scene, device="cpu"), view


def shown(textures, aov="albedo", **values) -> np.ndarray:
    renderer, view = card_with(textures, **values)
    renderer.sync()
    return renderer.labels(view, [aov])[aov]


def coordinates() -> tuple[np.ndarray, np.ndarray]:
    """(u, v) of every pixel's center."""
    along = (np.arange(SIZE) + 0.5) / SIZE
    return np.meshgrid(along, along[::-1])


def bilinear(values: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A repeating image at u, v."""
    height, width = values.shape[:2]
    x, y = u * width - 0.5, (1.0 - v) * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros((*u.shape, values.shape[2]))
    for di in (0, 1):
        for dj in (0, 1):
            weight = (1 - np.abs(x - i - di)) * (1 - np.abs(y - j - dj))
            total += values[(j + dj) % height, (i + di) % width] * weight[..., None]
    return total


@pytest.mark.parametrize(("kind", "tolerance"), [("uint8", 2e-5), ("uint16", 2e-5), ("float16", 2e-5)])
def test_texels_of_every_precision_are_interpolated_as_numpy_does(kind, tolerance):
    rng = np.random.default_rng(1)
    if kind == "float16":
        texels = rng.uniform(-1.0, 40.0, (5, 7, 4)).astype(np.float16)
        texels[0, 0, 0], texels[0, 1, 0] = 6e-8, 65504.0  # the smallest and the largest
        values, bias = texels.astype(float), (2.0, 2.0, 2.0, 0.0)
    else:
        most = np.iinfo(kind).max
        texels = rng.integers(0, most + 1, (5, 7, 4)).astype(kind)
        values, bias = texels / float(most), (0.0,) * 4
    image = Texture("t", texels, False, WRAP_REPEAT, WRAP_REPEAT, scale=(0.5, 2.0, 1.0, 1.0), bias=bias)
    expected = np.maximum(bilinear(values, *coordinates()) * image.scale + bias, 0.0)[..., :3]
    np.testing.assert_allclose(shown([image], base_color_texture=0), expected, rtol=tolerance, atol=tolerance)


def test_sixteen_bits_are_finer_than_eight():
    ramp = np.linspace(0.5, 0.51, 64)
    texels = np.repeat(np.round(ramp * 65535)[None, :, None], 4, axis=2).astype(np.uint16)
    albedo = shown([Texture("ramp", texels, False, WRAP_CLAMP, WRAP_CLAMP)], base_color_texture=0)[32, :, 0]
    assert len(np.unique(albedo)) == 64
    np.testing.assert_allclose(albedo, ramp, atol=1e-5)


def test_textures_of_one_material_have_a_transform_each():
    rng = np.random.default_rng(2)
    texels = rng.integers(0, 256, (4, 4, 4)).astype(np.uint8)
    turned = UvTransform.of((2.0, 3.0), 0.7, (0.1, -0.2))
    textures = [
        Texture("base", texels, False, WRAP_REPEAT, WRAP_REPEAT),
        Texture("rough", texels, False, WRAP_REPEAT, WRAP_REPEAT, turned),
    ]
    values = dict(base_color_texture=0, roughness_texture=1, roughness_channel=1)
    u, v = coordinates()
    cos, sin = np.cos(0.7), np.sin(0.7)
    u2, v2 = cos * 2 * u - sin * 3 * v + 0.1, sin * 2 * u + cos * 3 * v - 0.2
    np.testing.assert_allclose(shown(textures, **values), bilinear(texels / 255, u, v)[..., :3], atol=1e-5)
    rough = shown(textures, "roughness", **values)
    np.testing.assert_allclose(rough, bilinear(texels / 255, u2, v2)[..., 1], atol=2e-5)


def test_tiles_lie_side_by_side_and_beyond_them_is_the_fallback():
    colors = {0: (255, 0, 0), 1: (0, 255, 0), 10: (0, 0, 255), 12: (255, 255, 255)}
    tiles = tuple(
        (place, Texture("t", np.full((2, 2, 4), (*color, 255), np.uint8), False, WRAP_CLAMP, WRAP_CLAMP))
        for place, color in colors.items()
    )
    beyond = np.full((1, 1, 4), 0.25, np.float16)
    # The square shows [-1, 3)^2.
    spread = UvTransform.of((4.0, 4.0), 0.0, (-1.0, -1.0))
    albedo = shown([Texture("t", beyond, False, WRAP_CLAMP, WRAP_CLAMP, spread, tiles=tiles)], base_color_texture=0)
    for row in range(4):
        for column in range(4):
            pixel = albedo[SIZE - 8 - 16 * row, 8 + 16 * column]
            place = 10 * (row - 1) + column - 1 if min(row, column) > 0 else -1
            expected = np.array(colors[place]) / 255 if place in colors else (0.25,) * 3
            np.testing.assert_allclose(pixel, expected, atol=1e-6)


def test_specular_textures_vary_over_the_surface():
    texels = np.zeros((1, 2, 4), np.uint8)
    texels[0, 1] = 255
    image = Texture("s", texels, False, WRAP_CLAMP, WRAP_CLAMP, UvTransform.of((1.0, 1.0), 0.0, (0.0, 0.0)))
    values = dict(base_color=0.0, specular=(0.9, 0.5, 0.1), specular_texture=0, roughness=0.3)
    reflected = shown([image], "specular", **values)
    np.testing.assert_allclose(reflected[32, 4], 0.0, atol=1e-6)
    np.testing.assert_allclose(reflected[32, 60], (0.9, 0.5, 0.1), rtol=1e-5)
    renderer, view = card_with([image], **values)
    renderer.sync()
    assert radiance(renderer._scene, view, samples=16)[32, 4].max() < 0.01


@pytest.mark.parametrize(("what", "bright"), [("clearcoat", 60), ("clearcoat_roughness", None)])
def test_coats_are_as_thick_and_rough_as_their_textures(what, bright):
    # A black base: in a white world all that is seen is the coat's reflection, 4 % head on, however rough it is.
    texels = np.zeros((1, 2, 4), np.uint8)
    texels[0, 1] = 255
    image = Texture("c", texels, False, WRAP_CLAMP, WRAP_CLAMP)
    values = {"clearcoat": 1.0, "clearcoat_roughness": 0.5, f"{what}_texture": 0, f"{what}_channel": 2}
    renderer, view = card_with([image], base_color=0.0, specular=0.0, **values)
    renderer.sync()
    image = radiance(renderer._scene, view, samples=64)
    if what == "clearcoat":
        assert image[28:36, 2:6].max() == 0.0
        np.testing.assert_allclose(image[28:36, bright - 4 : bright].mean(), 0.04, rtol=0.15)
    else:
        # A mirror shows the world as it is, without noise.
        np.testing.assert_allclose(image[28:36, 2:6].mean(), 0.04, rtol=0.1)
        assert image[28:36, 2:6].std() < 0.01


def test_a_detail_map_adds_its_slopes():
    def flat_map(x, y):
        normal = np.array([x, y, np.sqrt(1 - x * x - y * y), 1.0])
        return np.round((normal[None, None] + 1) / 2 * 65535).astype(np.uint16)

    textures = [
        Texture("n", flat_map(0.3, 0.0), False, WRAP_CLAMP, WRAP_CLAMP),
        Texture("d", flat_map(0.0, 0.4), False, WRAP_CLAMP, WRAP_CLAMP),
    ]
    seen = shown(textures, "bump_normals", normal_texture=0, detail_texture=1, detail_scale=0.5)
    expected = np.array([0.3, 0.2, np.sqrt(1 - 0.09)])
    np.testing.assert_allclose(seen[32, 32], expected / np.linalg.norm(expected), atol=1e-4)
    alone = shown(textures, "bump_normals", detail_texture=1, detail_scale=0.5)
    np.testing.assert_allclose(alone[32, 32], np.array([0, 0.2, 1]) / np.hypot(0.2, 1), atol=1e-4)
