"""The number of samples of a frame, their split into sub-frames, and the choice of the denoiser."""

import warnings

import pytest

from usdsdg.capture.render_settings import RenderMode, render_mode
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session.session import current
from usdsdg.session.settings.store import Settings
from usdsdg_render.path import oidn_denoiser


@pytest.fixture
def settings(monkeypatch):
    fresh = Settings()
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: False)
    monkeypatch.setattr(current(), "settings", fresh)
    forget_warnings()
    return fresh


@pytest.fixture(params=[True, False], ids=["with oidn", "without"])
def has_oidn(request, monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: request.param)
    return request.param


@pytest.mark.parametrize(("samples", "parts"), [(128, 8), (10, 4), (3, 8), (1, 1)])
def test_a_split_covers_the_samples_once_and_in_order(samples, parts):
    mode = RenderMode(True, samples, parts, True, False, first_sample=5)
    modes = mode.split(parts)
    covered = [n for each in modes for n in range(each.first_sample, each.first_sample + each.samples)]
    assert covered == list(range(5, 5 + samples))
    assert all(each.samples > 0 for each in modes)


def test_every_sub_frame_of_the_fast_mode_adds_a_sample(settings):
    assert [render_mode(count).samples for count in (1, 2, 32)] == [5, 6, 36]
    assert not render_mode(4).motion_blur


def test_path_tracing_reads_total_spp_and_motion_blur(settings):
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/totalSpp", 100)
    assert (render_mode(1).samples, render_mode(1).motion_blur) == (100, False)
    settings.set("/omni/replicator/captureMotionBlur", True)
    settings.set("/omni/replicator/pathTracedMotionBlurSubSamples", 5)
    assert (render_mode(1).sub_frames, render_mode(1).motion_blur) == (5, True)


@pytest.fixture
def said(monkeypatch) -> list[str]:
    """The lines that are reported."""
    lines: list[str] = []
    monkeypatch.setattr(current(), "said", set())
    monkeypatch.setattr("usdsdg.session.progress.say", lines.append)
    return lines


def test_an_unknown_render_mode_warns(settings):
    settings.set("/rtx/rendermode", "Wireframe")
    with pytest.warns(UsdsdgWarning, match="Wireframe"):
        render_mode(1)


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_path_traced_images_use_the_best_denoiser_available(settings, has_oidn):
    assert render_mode(1).denoiser == "wavelet"
    settings.set("/rtx/rendermode", "PathTracing")
    assert (render_mode(1).denoise, render_mode(1).denoiser) == (True, "oidn" if has_oidn else "wavelet")


@pytest.mark.parametrize("name", ["wavelet", "oidn"])
@pytest.mark.parametrize("mode", ["PathTracing", "RaytracedLighting"])
def test_a_denoiser_named_by_the_setting_is_used_without_a_warning(settings, has_oidn, mode, name):
    settings.set("/rtx/rendermode", mode)
    settings.set("/usdsdg/denoiser", name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert render_mode(1).denoiser == name


def test_a_missing_better_denoiser_is_told_once(settings, monkeypatch, said):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: False)
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/optixDenoiser/enabled", True)
    render_mode(1)
    render_mode(1)
    assert ["pip install 'usdsdg[denoise]'" in line for line in said] == [True]


def test_a_processor_without_sve_uses_the_wavelet_filter(settings, has_oidn, monkeypatch, said):
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: True)
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/optixDenoiser/enabled", True)
    assert render_mode(1).denoiser == "wavelet"
    assert ["needs a processor with SVE on aarch64" in line for line in said] == [True]


def test_images_that_are_not_denoised_need_no_denoiser(settings, monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: False)
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/optixDenoiser/enabled", False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not render_mode(1).denoise


def test_an_unknown_denoiser_warns(settings, monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: True)
    settings.set("/usdsdg/denoiser", "optix")
    with pytest.warns(UsdsdgWarning, match="'optix' is not known; using auto"):
        assert render_mode(1).denoiser == "wavelet"


@pytest.mark.parametrize(("given", "taken"), [(0.0, 0.0), (0.25, 0.25), (1, 1.0)])
def test_the_blend_factor_is_the_weight_of_the_noisy_image(settings, monkeypatch, given, taken):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: True)
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/optixDenoiser/blendFactor", given)
    assert render_mode(1).denoiser_blend == taken


@pytest.mark.parametrize(("given", "taken"), [(1.5, 1.0), (-1, 0.0), (float("nan"), 0.0)])
def test_blend_factors_out_of_range_warn_and_are_clamped(settings, monkeypatch, given, taken):
    monkeypatch.setattr(oidn_denoiser, "is_installed", lambda: True)
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/optixDenoiser/blendFactor", given)
    with pytest.warns(UsdsdgWarning, match="blendFactor is .*; it may be 0"):
        assert render_mode(1).denoiser_blend == taken


def test_the_fast_mode_has_no_blend_factor(settings):
    settings.set("/rtx/pathtracing/optixDenoiser/blendFactor", 0.5)
    assert render_mode(1).denoiser_blend == 0.0
