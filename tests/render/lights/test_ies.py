"""IES files: parsing, completion of symmetric files, angle scale and normalization of UsdLux."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Usd, UsdLux

from usdsdg import errors
from usdsdg_render.lights import ies
from usdsdg_render.lights.emission_profiles import read_emission_profile

VERTICAL = [0, 30, 60, 90]
DOWNLIGHT = [1000, 800, 200, 0]


def file_of(vertical, horizontal, candela, *, multiplier=1, tilt="TILT=NONE", kind=1, ballast="1 1", units=2) -> str:
    candela = np.broadcast_to(candela, (len(horizontal), len(vertical)))
    lines = ["IESNA:LM-63-1995", "[TEST] by hand", "[MANUFAC] none", tilt]
    lines += [f"1 -1 {multiplier} {len(vertical)} {len(horizontal)} {kind} {units} 0.1 0.1 0", f"{ballast} 60"]
    lines += [" ".join(map(str, vertical)), " ".join(map(str, horizontal))]
    lines += [" ".join(map(str, row)) for row in candela]
    return "\r\n".join(lines) + "\r\n"


def at(text: str, vertical: float, horizontal: float) -> float:
    return float(ies.candela_at(ies.parse(text, name="a.ies"), np.array([vertical]), np.array([horizontal]))[0, 0])


def test_intensity_is_linear_between_angles():
    text = file_of(VERTICAL, [0], DOWNLIGHT)
    assert at(text, 0, 0) == 1000
    assert at(text, 15, 123) == 900
    assert at(text, 45, 7) == 500
    # Zero above the horizontal, where the file ends.
    assert at(text, 91, 0) == 0


def test_multipliers_apply_and_commas_are_spaces():
    text = file_of(VERTICAL, [0], DOWNLIGHT, multiplier=2, ballast="0.5, 0.8")
    assert at(text, 30, 0) == pytest.approx(800 * 2 * 0.5 * 0.8)


def test_tilt_data_is_skipped():
    tilt = "TILT=INCLUDE\r\n1\r\n3\r\n0 45 90\r\n1 .9 .8"
    assert at(file_of(VERTICAL, [0], DOWNLIGHT, tilt=tilt), 30, 0) == 800


@pytest.mark.parametrize(
    ("horizontal", "same"),
    [
        ([0, 45, 90], [(20, 160), (20, 200), (20, 340), (90, 270), (0, 180)]),
        ([0, 45, 90, 135, 180], [(20, 340), (160, 200), (90, 270)]),
        ([90, 135, 180, 225, 270], [(100, 80), (170, 10), (200, 340), (270, 270)]),
    ],
)
def test_symmetric_files_are_mirrored(horizontal, same):
    rng = np.random.default_rng(5)
    text = file_of(VERTICAL, horizontal, rng.uniform(0, 1000, (len(horizontal), len(VERTICAL))).round(1))
    for a, b in same:
        assert at(text, 40, a) == pytest.approx(at(text, 40, b))


def test_full_circles_close_if_the_last_angle_is_omitted():
    candela = np.arange(4)[:, None] * np.ones(4) * 100
    text = file_of(VERTICAL, [0, 90, 180, 270], candela)
    assert at(text, 0, 300) == pytest.approx(300)
    whole = file_of(VERTICAL, [0, 90, 180, 270, 360], np.concatenate([candela, candela[:1]]))
    assert at(whole, 0, 315) == pytest.approx(150)
    eight = file_of(VERTICAL, list(range(0, 360, 45)), np.arange(8)[:, None] * np.ones(4) * 100)
    assert at(eight, 0, 337.5) == pytest.approx(350)


def test_profiles_sample_the_file_at_their_angles():
    profile = ies.profile(ies.parse(file_of(VERTICAL, [0], DOWNLIGHT), name="a.ies"))
    assert profile.shape == (ies.ROWS, 1)
    assert profile[0, 0] == 1000
    assert profile[60 * 4, 0] == 200
    assert profile[-1, 0] == 0


@pytest.mark.parametrize(
    ("scale", "angle", "seen"), [(0.5, 15, 30), (1.5, 90, 60), (-0.5, 170, 160), (-2.0, 60, 120), (0.0, 40, 40)]
)
def test_angle_scale_stretches_about_nadir_or_zenith(scale, angle, seen):
    candela = [1000.0, 900.0, 700.0, 400.0, 300.0, 250.0, 100.0]
    text = file_of([0, 30, 60, 90, 120, 150, 180], [0], candela)
    profile = ies.profile(ies.parse(text, name="a.ies"), angle_scale=scale)
    expected = np.interp(seen, np.arange(7) * 30, candela)
    assert profile[angle * 4, 0] == pytest.approx(expected, rel=1e-5)


def test_normalized_profiles_have_a_mean_of_one_over_the_covered_angles():
    for vertical, ends in ((np.arange(0, 91, 5), 90), (np.arange(0, 181, 5), 180)):
        candela = 3.0 + 500 * np.cos(np.radians(vertical / 2)) ** 4
        parsed = ies.parse(file_of(vertical.tolist(), [0], candela.tolist()), name="a.ies")
        profile = ies.profile(parsed, normalize=True)[:, 0]
        theta = np.radians(np.arange(ies.ROWS) * 0.25)
        covered = theta <= np.radians(ends)
        mean = (profile * np.sin(theta))[covered].sum() / np.sin(theta)[covered].sum()
        assert mean == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("no such thing", "TILT"),
        (file_of(VERTICAL, [0], DOWNLIGHT, kind=2), "type 2"),
        (file_of(VERTICAL, [0], DOWNLIGHT)[:-12], "ask for"),
        (file_of([0, 60, 30, 90], [0], DOWNLIGHT), "rise"),
        ("TILT=NONE\n1 2 x", "could not convert"),
        ("TILT=NONE\n1 2 3", "ends early"),
    ],
)
def test_files_that_are_not_type_c_are_refused(text, why):
    with pytest.raises(errors.AssetUnreadable, match=why):
        ies.parse(text, name="a.ies")


def test_lights_take_profiles_from_their_shaping_inputs(tmp_path):
    path = tmp_path / "down.ies"
    path.write_text(file_of(VERTICAL, [0], DOWNLIGHT))
    stage = Usd.Stage.CreateInMemory()
    prim = UsdLux.SphereLight.Define(stage, "/Light").GetPrim()
    shaping = UsdLux.ShapingAPI.Apply(prim)
    assert read_emission_profile(prim) is None
    shaping.CreateShapingIesFileAttr(str(path))
    first = read_emission_profile(prim)
    assert first is not None
    assert first.ies is not None
    assert first.ies[0, 0] == 1000
    assert read_emission_profile(prim) is first
    shaping.CreateShapingIesNormalizeAttr(True)
    shaping.CreateShapingIesAngleScaleAttr(0.5)
    second = read_emission_profile(prim)
    assert second is not None
    assert second.ies is not None
    assert 1 < second.ies[0, 0] < 10
    assert second.ies[46 * 4, 0] == 0
    path.write_text("broken")
    with pytest.warns(UserWarning, match="/Light: the IES profile cannot be read.*TILT"):
        assert read_emission_profile(prim) is None
