"""How many samples a frame gets, and how they are shared out."""

import pytest

from usdsdg.errors import UsdsdgWarning
from usdsdg.render_settings import RenderMode, render_mode
from usdsdg.settings import Settings


@pytest.fixture
def settings(monkeypatch):
    fresh = Settings()
    monkeypatch.setattr("usdsdg.render_settings.get_settings", lambda: fresh)
    return fresh


@pytest.mark.parametrize(("samples", "parts"), [(128, 8), (10, 4), (3, 8), (1, 1)])
def test_shares_cover_the_samples_once_and_in_order(samples, parts):
    mode = RenderMode(True, samples, parts, True, False, first_sample=5)
    shares = mode.split(parts)
    covered = [n for share in shares for n in range(share.first_sample, share.first_sample + share.samples)]
    assert covered == list(range(5, 5 + samples))
    assert all(share.samples > 0 for share in shares)


def test_every_sub_frame_of_the_fast_mode_adds_a_sample(settings):
    assert [render_mode(count).samples for count in (1, 2, 32)] == [5, 6, 36]
    assert not render_mode(4).motion_blur


def test_path_tracing_takes_total_spp_and_blurs_where_asked(settings):
    settings.set("/rtx/rendermode", "PathTracing")
    settings.set("/rtx/pathtracing/totalSpp", 100)
    assert (render_mode(1).samples, render_mode(1).motion_blur) == (100, False)
    settings.set("/omni/replicator/captureMotionBlur", True)
    settings.set("/omni/replicator/pathTracedMotionBlurSubSamples", 5)
    assert (render_mode(1).sub_frames, render_mode(1).motion_blur) == (5, True)


def test_an_unknown_mode_is_named(settings):
    settings.set("/rtx/rendermode", "Wireframe")
    with pytest.warns(UsdsdgWarning, match="Wireframe"):
        render_mode(1)
