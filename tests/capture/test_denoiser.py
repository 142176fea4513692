"""Denoisers of path-traced images in real captures; they change images and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

import usdsdg as rep
from tests.render.path.films import needs_library
from usdsdg.errors import forget_warnings
from usdsdg.session.session import current
from usdsdg.session.settings import store as settings
from usdsdg.session.stage_context import new_stage
from usdsdg_render.path import oidn_denoiser

ENABLED = "/rtx/pathtracing/optixDenoiser/enabled"
BLEND = "/rtx/pathtracing/optixDenoiser/blendFactor"
DENOISER = "/usdsdg/denoiser"
LABELS = ("distance_to_camera", "normals", "DiffuseAlbedo", "DirectDiffuse")


@pytest.fixture
def captured(monkeypatch):
    """Capture a path-traced frame of a ball on a floor with some settings: ({key: value}) → {annotator: array}."""
    forget_warnings()

    def frame(values: dict) -> dict[str, np.ndarray]:
        monkeypatch.setattr(settings.get_settings(), "_values", dict(settings.DEFAULTS))
        new_stage()
        rep.set_global_seed(5)
        rep.create.light(light_type="dome", intensity=800)
        rep.create.plane(scale=20, semantics=[("class", "floor")])
        rep.create.sphere(position=(0, 0, 0.5), semantics=[("class", "ball")])
        camera = rep.create.camera(position=(0, -4, 3), look_at=(0, 0, 0.4), f_stop=0.05, focus_distance=2.0)
        product = rep.create.render_product(camera, (64, 48))
        rep.settings.set_render_pathtraced(8)
        for key, value in values.items():
            rep.settings.carb_settings(key, value)
        found = {name: rep.annotators.get(name).attach(product) for name in ("rgb", "HdrColor", *LABELS)}
        masks = rep.annotators.get("semantic_segmentation").attach(product)
        rep.orchestrator.step()
        return {name: each.get_data() for name, each in found.items()} | {"masks": masks.get_data()["data"]}

    return frame


def roughness(image: np.ndarray) -> float:
    """Return the mean difference of neighboring pixels."""
    levels = image[..., :3].astype(np.float64)
    return float(np.abs(np.diff(levels, axis=0)).mean() + np.abs(np.diff(levels, axis=1)).mean())


@needs_library
def test_it_denoises_images_and_does_not_change_labels(captured):
    clean, noisy, ours = captured({}), captured({ENABLED: False}), captured({DENOISER: "wavelet"})
    for name in ("rgb", "HdrColor"):
        assert roughness(clean[name]) < 0.5 * roughness(noisy[name])
        assert roughness(clean[name]) < 0.7 * roughness(ours[name])
    for name in ("masks", *LABELS):
        assert np.array_equal(clean[name], noisy[name])
        assert np.array_equal(clean[name], ours[name])


@needs_library
def test_auto_is_oidn_if_installed_and_captures_are_reproducible(captured):
    images = [captured(values)["HdrColor"] for values in ({}, {DENOISER: "oidn"}, {ENABLED: True, BLEND: 0.0})]
    assert np.array_equal(images[0], images[1])
    assert np.array_equal(images[0], images[2])


@needs_library
def test_the_blend_factor_goes_from_denoised_to_noisy(captured):
    clean, noisy = captured({})["HdrColor"], captured({ENABLED: False})["HdrColor"]
    half = captured({BLEND: 0.5})["HdrColor"]
    np.testing.assert_allclose(half, (clean.astype(np.float32) + noisy) / 2, rtol=2**-9)
    np.testing.assert_array_equal(captured({BLEND: 1.0})["HdrColor"], noisy)


@needs_library
def test_the_fast_mode_uses_it_if_the_setting_names_it(captured):
    fast = {"/rtx/rendermode": "RaytracedLighting"}
    assert roughness(captured({**fast, DENOISER: "oidn"})["rgb"]) < 0.7 * roughness(captured(fast)["rgb"])


def test_a_script_that_enables_optix_runs_without_the_extra(captured, monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: False)
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: False)
    lines: list[str] = []
    monkeypatch.setattr(current(), "said", set())
    monkeypatch.setattr("usdsdg.session.progress.say", lines.append)
    fallback = captured({ENABLED: True, BLEND: 0.0})["HdrColor"]
    assert sum("usdsdg[denoise]" in line for line in lines) == 1
    assert np.array_equal(fallback, captured({DENOISER: "wavelet"})["HdrColor"])
