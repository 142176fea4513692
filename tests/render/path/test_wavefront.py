"""The wavefront path tracer gives the image of the CPU's; its kernels run on a CPU here, one thread after the other."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import DEVICE, renderer_of
from usdsdg_render.device.camera import views_record
from usdsdg_render.path.path_tracer import path_options
from usdsdg_render.path.wavefront import WavefrontTracer
from usdsdg_render.settings import PathSettings

VIEW = scenes.view_from((0, -4, 2), size=(12, 9), f_stop=1.0, focus_distance=4.0)


def everything():
    """A floor, a mirror, a plastic ball, glass, a lamp and a sky."""
    materials = [
        scenes.material(base_color=0.5, roughness=0.4, emission=0.1),
        scenes.material(metallic=1.0, roughness=0.05),
        scenes.material(base_color=(0.8, 0.2, 0.1), clearcoat=0.5, opacity=0.6),
        scenes.material(transmission=1.0, roughness=0.0),
    ]
    placed = [(scenes.square(), scenes.moved(scale=10), 0)]
    placed += [(scenes.sphere(), scenes.moved((x, 0, 0.5), scale=0.5), k) for k, x in enumerate((-1.2, 0, 1.2), 1)]
    lamp = scenes.sphere_light(50.0, (0, -1, 3), 0.2)
    return scenes.scene_of(placed, materials=materials, lights=[lamp], dome=scenes.white_dome())


@pytest.mark.parametrize("max_paths", [1 << 20, 250, 70])
@pytest.mark.parametrize("wanted", [{}, {"denoise": True, "light_aovs": True}])
def test_wavefronts_of_any_size_give_the_same_image(max_paths, wanted):
    renderer = renderer_of(everything())
    settings = PathSettings(first_sample=3, **wanted)
    film = renderer.new_film(VIEW.width, VIEW.height)
    renderer.accumulate(film, VIEW, samples=7, settings=settings)
    other = renderer.new_film(VIEW.width, VIEW.height)
    if wanted:
        other.allocate_features()
        other.allocate_light_aovs()
    tables = renderer._on_device.tables
    WavefrontTracer(DEVICE, max_paths).add_samples(
        tables, path_options(settings, other), views_record([VIEW], DEVICE), [other.arrays], 7
    )
    extra = ("background", "albedo", "normal_depth", "square", "light_aovs") if wanted else ()
    for name in ("color", "dropped", *extra):
        np.testing.assert_array_equal(
            getattr(other.arrays, name).numpy(), getattr(film.arrays, name).numpy(), err_msg=name
        )
    assert film.radiance().mean() > 0.3


def test_pixels_without_camera_rays_match():
    view = scenes.view_from((0, -4, 2), size=(12, 9), clipping_range=(0.1, 3.0))
    renderer = renderer_of(everything())
    film, other = (renderer.new_film(12, 9) for _ in range(2))
    renderer.accumulate(film, view, samples=2, settings=PathSettings())
    options = path_options(PathSettings(), other)
    WavefrontTracer(DEVICE, 100).add_samples(
        renderer._on_device.tables, options, views_record([view], DEVICE), [other.arrays], 2
    )
    np.testing.assert_array_equal(other.arrays.color.numpy(), film.arrays.color.numpy())


@pytest.mark.parametrize("max_paths", [1 << 20, 150])
def test_views_of_one_wavefront_give_the_images_of_each_alone(max_paths):
    renderer = renderer_of(everything())
    eyes = [(0, -4, 2), (4, 0, 1), (1, 3, 3)]
    views = [scenes.view_from(eye, size=(12, 9), f_stop=k, focus_distance=4.0) for k, eye in enumerate(eyes)]
    films, others = ([renderer.new_film(12, 9) for _ in views] for _ in range(2))
    renderer.accumulate_all(films, views, samples=3, settings=PathSettings())
    options = path_options(PathSettings(), others[0])
    tables, arrays = renderer._on_device.tables, [other.arrays for other in others]
    WavefrontTracer(DEVICE, max_paths).add_samples(tables, options, views_record(views, DEVICE), arrays, 3)
    for film, other, view in zip(films, others, views, strict=True):
        alone = renderer.new_film(12, 9)
        renderer.accumulate(alone, view, samples=3, settings=PathSettings())
        for drawn in (film, other):
            np.testing.assert_array_equal(drawn.arrays.color.numpy(), alone.arrays.color.numpy())
