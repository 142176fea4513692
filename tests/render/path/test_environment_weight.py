"""The selection weight of environment light: it follows visibility, and images converge to the same mean with any."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render import scenes
from tests.render.images import EXACT, renderer_of
from tests.sampled_cases import crossed
from usdsdg_render.device.camera import camera_array
from usdsdg_render.kernels.path.environment_weight import MIN_WEIGHT
from usdsdg_render.path import path_tracer
from usdsdg_render.path.environment_weight import set_environment_weights
from usdsdg_render.settings import PathSettings

VIEW = scenes.view_from((0, -0.9, 0), (0, 1, 0), size=(24, 18), focal_length=12.0)
# Rotations of a square that faces z: toward y, toward x.
TO_Y = np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0)])
TO_X = np.array([(0, 0, 1), (0, 1, 0), (-1, 0, 0)])


def room(*, window: float = 0.0, lamp: bool = True, sky: float = 1.0, sun: float = 0.0) -> scenes.Scene:
    """Walls two units apart around the camera and a lamp at the ceiling; a fraction of the wall at +x is missing.

    The sun is on that side.
    """
    wall = scenes.square()
    placed = [(wall, scenes.moved((0, 0, z)), 0) for z in (-1, 1)]
    placed += [(wall, scenes.moved((0, y, 0), rotation=TO_Y), 0) for y in (-1, 1)]
    placed += [(wall, scenes.moved((-1, 0, 0), rotation=TO_X), 0)]
    if window < 1.0:
        placed += [(wall, scenes.moved((1, 0, window), scale=(1 - window, 1, 1), rotation=TO_X), 0)]
    lights = [scenes.sphere_light(50.0, (0, 0, 0.8), 0.1)] if lamp else []
    lights += [scenes.distant_light(sun, (-1, 0, 0.1))] if sun else []
    materials = [scenes.material(base_color=0.5, specular=0.0, roughness=1.0)]
    return scenes.scene_of(placed, materials=materials, lights=lights, dome=scenes.white_dome(sky))


def weight_of(scene: scenes.Scene, view=VIEW) -> float:
    renderer = renderer_of(scene)
    cameras = camera_array([view], renderer.device)
    set_environment_weights(renderer._on_device, cameras, threads=1)
    return float(cameras.numpy()["environment_weight"][0])


def set_weights(monkeypatch: pytest.MonkeyPatch, value: float) -> None:
    """Let all cameras have a weight."""

    def set_to_value(scene, cameras, *, threads):
        rows = cameras.numpy()
        rows["environment_weight"] = value
        cameras.assign(rows)

    monkeypatch.setattr(path_tracer, "set_environment_weights", set_to_value)


def test_the_weight_follows_the_size_of_the_window():
    assert weight_of(room()) == MIN_WEIGHT
    weights = [weight_of(room(window=window)) for window in (0.1, 0.4, 1.0)]
    assert MIN_WEIGHT <= weights[0] <= weights[1] <= weights[2] < 1.0
    assert weights[2] > 4 * MIN_WEIGHT
    # Outside, before one wall.
    assert weight_of(room(), scenes.view_from((0, -9, 0), (0, 0, 0))) == 1.0


def test_the_weight_is_one_without_local_lights():
    assert weight_of(room(lamp=0.0)) == 1.0


def test_the_weight_counts_distant_lights():
    towards_the_sun = scenes.view_from((-0.9, 0, 0), (1, 0, 0), size=(24, 18), focal_length=12.0)
    behind_the_wall = weight_of(room(sun=1e4, window=0.1), towards_the_sun)
    assert behind_the_wall == MIN_WEIGHT
    assert weight_of(room(sun=1e4, window=1.0), VIEW) > behind_the_wall


@pytest.mark.parametrize(
    ("scene", "share"),
    crossed([room(), room(window=0.3), room(window=1.0, sun=2.0)], [MIN_WEIGHT, 0.25]),
)
def test_images_converge_to_the_same_mean_with_any_weight(scene, share, monkeypatch):
    def mean(value):
        set_weights(monkeypatch, value)
        renderer = renderer_of(scene, threads=2)
        film = renderer.new_film(VIEW.width, VIEW.height)
        renderer.accumulate(film, VIEW, samples=512, settings=PathSettings(**EXACT, bounces=3))
        return film.radiance().mean()

    assert mean(share) == pytest.approx(mean(1.0), rel=0.01)


def test_a_lit_room_under_a_bright_sky_has_a_tenth_of_the_noise(monkeypatch):
    scene = room(sky=20.0)

    def variance():
        renderer = renderer_of(scene, threads=2)
        films = [renderer.new_film(VIEW.width, VIEW.height) for _ in range(4)]
        for k, film in enumerate(films):
            settings = PathSettings(**EXACT, first_sample=64 * k, bounces=2)
            renderer.accumulate(film, VIEW, samples=8, settings=settings)
        return np.var([film.radiance() for film in films], axis=0).mean()

    now = variance()
    set_weights(monkeypatch, 1.0)
    assert now < variance() / 10
