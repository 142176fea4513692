"""Denoising by Open Image Denoise: inputs and results, determinism, and errors without the library."""

import subprocess
import sys

import numpy as np
import pytest
import warp as wp

from tests.render.path.films import denoise as wavelet
from tests.render.path.films import developed, film_of, needs_library, rms
from usdsdg.errors import RenderError
from usdsdg_render.path import oidn_denoiser
from usdsdg_render.settings import ToneSettings

HEIGHT, WIDTH = 61, 83
OIDN = ToneSettings(denoiser="oidn")


def stripes():
    """Light, albedo and normals that vary over an image."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    light = (100.0 + 80.0 * np.sin(x / 9.0))[..., None] * np.array([1.0, 0.9, 0.7])
    albedo = np.where((x // 6 + y // 6) % 2, 0.8, 0.2)[..., None] * np.array([1.0, 0.8, 0.6])
    normal = np.stack([np.sin(y / 20.0), np.zeros(x.shape), np.cos(y / 20.0)], -1)
    return light, albedo, normal


def striped_film(scale=1.0, **changes):
    light, albedo, normal = stripes()
    return film_of(light * scale, albedo=albedo, normal=normal, **changes)


def filtered(film, **options):
    return oidn_denoiser.denoise(film.arrays, "cpu", **options).numpy()[..., :3]


@needs_library
def test_the_result_is_that_of_the_library_on_the_means_of_the_film():
    """Within the effect of its own input scale and of the border."""
    import mitsuba_oidn

    film = striped_film()
    samples = film.arrays.color.numpy()[..., 3:]
    means = film.radiance(), film.arrays.albedo.numpy() / samples, film.arrays.normal_depth.numpy()[..., :3] / samples
    color, albedo, normal = (np.pad(each, ((8, 8), (8, 8), (0, 0)), mode="symmetric") for each in means)
    expected = mitsuba_oidn.denoise(color, albedo, normal, hdr=True, clean_aux=True)[8:-8, 8:-8]
    assert rms(filtered(film), expected) < 0.02 * rms(film.radiance(), expected)


@needs_library
def test_noise_is_removed_and_textures_stay():
    light, albedo, _ = stripes()
    film = striped_film(noise=1.0)
    assert rms(filtered(film), light * albedo) < rms(film.radiance(), light * albedo) / 4


@needs_library
def test_noise_of_the_guides_is_removed_unlike_by_the_wavelet():
    """Depth of field and motion blur: every sample of a pixel may see another surface."""
    truth = np.full((HEIGHT, WIDTH, 3), 100.0)
    albedo = np.random.default_rng(3).uniform(0.2, 0.8, (HEIGHT, WIDTH, 1)) * np.ones(3)
    film = film_of(truth, albedo=albedo, noise=0.05)
    pictures = film.radiance(), wavelet(film.arrays, "cpu").numpy()[..., :3], filtered(film)
    raw, waved, clean = (rms(picture, 0.5 * truth) for picture in pictures)
    assert waved > 0.9 * raw
    assert clean < 0.4 * raw


@needs_library
def test_pixels_at_the_border_are_as_accurate_as_others():
    truth = np.full((64, 64, 3), 100.0)
    error = np.sqrt(np.mean([(filtered(film_of(truth, seed=seed)) - truth) ** 2 for seed in range(8)], axis=(0, -1)))
    inside = np.zeros((64, 64), bool)
    inside[8:-8, 8:-8] = True
    outermost = np.ones((64, 64), bool)
    outermost[1:-1, 1:-1] = False
    # A pixel at the border has half of the neighbors, one in a corner a quarter.
    assert error[outermost].mean() < 2.5 * error[inside].mean()


@needs_library
def test_results_are_equal_bit_for_bit_with_any_number_of_threads():
    film = striped_film()
    first = filtered(film)
    for threads in (1, 2, 3, None, 1):
        assert np.array_equal(filtered(film, threads=threads), first)


@needs_library
def test_images_of_other_sizes_in_between_change_nothing():
    film = striped_film()
    first = filtered(film)
    for size in range(1, 7):
        assert filtered(film_of(np.full((size, 2 * size, 3), 50.0))).shape == (size, 2 * size, 3)
    assert np.array_equal(filtered(film), first)


@needs_library
@pytest.mark.parametrize("stops", [-20, -8, 8, 14])
def test_denoising_does_not_depend_on_exposure(stops):
    """The input scale normalizes exposure: powers of two change nothing but rounding."""
    np.testing.assert_allclose(filtered(striped_film(2.0**stops)) / 2.0**stops, filtered(striped_film()), rtol=2e-3)


@needs_library
def test_the_mean_is_preserved():
    light, albedo, _ = stripes()
    np.testing.assert_allclose(filtered(striped_film()).mean((0, 1)), (light * albedo).mean((0, 1)), rtol=0.01)


@needs_library
def test_a_black_image_stays_black():
    assert not filtered(film_of(np.zeros((20, 20, 3)))).any()


@needs_library
def test_pixels_without_samples_stay_clear():
    film = striped_film()
    color = film.arrays.color.numpy()
    color[:10] = 0.0
    film.arrays.color.assign(color)
    out = developed(film, OIDN)
    assert not out["HdrColor"][:10].any()
    assert (out["HdrColor"][10:, :, 3] == 1).all()


@needs_library
def test_tone_mapping_denoises_and_blends():
    film = striped_film()
    assert np.array_equal(developed(film, OIDN)["HdrColor"][..., :3], filtered(film).astype(np.float16))
    share = ToneSettings(denoiser="oidn", denoiser_blend=0.5)
    expected = (film.radiance() + filtered(film)) / 2
    np.testing.assert_allclose(developed(film, share)["HdrColor"][..., :3], expected, rtol=2**-10)


@needs_library
def test_the_interpreter_exits_without_leak_reports():
    code = (
        "import numpy as np; from tests.render.path.films import film_of\n"
        "from usdsdg_render.path import oidn_denoiser\n"
        "oidn_denoiser.denoise(film_of(np.ones((9, 9, 3))).arrays, 'cpu')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert "leak" not in done.stdout + done.stderr
    assert "mitsuba" not in done.stdout + done.stderr


def test_the_error_without_the_library_names_the_extra(monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: False)
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    film = film_of(np.ones((4, 4, 3)))
    with pytest.raises(RenderError, match=r"pip install 'usdsdg\[denoise\]', or .* 'wavelet'"):
        developed(film, OIDN)


def test_the_error_on_a_processor_without_sve_names_it(monkeypatch):
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: True)
    with pytest.raises(RenderError, match=r"needs a processor with SVE.* 'wavelet'"):
        developed(film_of(np.ones((4, 4, 3))), OIDN)


@pytest.mark.parametrize(
    ("features", "lacks"), [(0x119FFB, True), (0xECFFFFFB, False)], ids=["Neoverse N1", "with SVE"]
)
def test_sve_is_detected_on_linux(monkeypatch, features, lacks):
    class CLibrary:
        def __init__(self, name):
            self.getauxval = lambda key: {16: features}[key]

    monkeypatch.setattr(oidn_denoiser.ctypes, "CDLL", CLibrary)
    monkeypatch.setattr(oidn_denoiser.sys, "platform", "linux")
    monkeypatch.setattr(oidn_denoiser.platform, "machine", lambda: "aarch64")
    assert oidn_denoiser.lacks_sve.__wrapped__() is lacks
    monkeypatch.setattr(oidn_denoiser.platform, "machine", lambda: "x86_64")
    assert not oidn_denoiser.lacks_sve.__wrapped__()


def test_the_error_names_a_missing_system_library(monkeypatch, tmp_path):
    """As on Linux without libatomic, where the binding raises no ImportError."""
    (tmp_path / "mitsuba_oidn.py").write_text("raise RuntimeError('could not load libnanothread.so')")
    monkeypatch.setattr(oidn_denoiser, "lacks_sve", lambda: False)
    monkeypatch.delitem(sys.modules, "mitsuba_oidn", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(RenderError, match=r"could not load libnanothread.so\).* .libatomic1 in .* or .* 'wavelet'"):
        developed(film_of(np.ones((4, 4, 3))), OIDN)


@pytest.mark.cuda
@pytest.mark.skipif(not wp.is_cuda_available(), reason="no CUDA device")
@needs_library
def test_cuda_gives_the_same_image_and_is_deterministic():
    film = striped_film()
    for name in ("color", "albedo", "normal_depth", "square"):
        setattr(film.arrays, name, getattr(film.arrays, name).to("cuda:0"))
    first = oidn_denoiser.denoise(film.arrays, "cuda:0").numpy()
    for _ in range(3):
        assert np.array_equal(oidn_denoiser.denoise(film.arrays, "cuda:0").numpy(), first)
    on_cpu = filtered(striped_film())
    # The networks use half floats there.
    assert rms(first[..., :3], on_cpu) < 0.05 * rms(striped_film().radiance(), on_cpu)
