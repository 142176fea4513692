"""A renderer that followed changes gives the very frame that a new renderer of the same stage gives, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.render.sync.changing_stage import make_stage
from tests.render.sync.value_edits import ALL_EDITS
from tests.sampled_cases import sampled
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

AOVS = ("instance", "prim", "distance_to_camera", "normals", "uv", "albedo", "roughness", "emission")


@pytest.fixture
def stage(tmp_path):
    return make_stage(tmp_path)


@pytest.fixture
def renderer(stage):
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    return renderer


def frame(renderer, stage, time=None):
    """Everything that a capture takes from a renderer."""
    renderer.sync(time)
    view = read_camera(stage, "/World/Camera", (48, 36), time=time)
    images = dict(renderer.labels(view, AOVS))
    film = renderer.new_film(view.width, view.height)
    renderer.accumulate(film, view, samples=1, settings=PathSettings(light_aovs=True))
    images |= renderer.develop(film)
    images["paths"] = np.array(renderer.gprims)
    return images


def assert_fresh(renderer, stage, time=None):
    ours, anew = frame(renderer, stage, time), frame(WarpRenderer(stage, device="cpu"), stage, time)
    assert ours.keys() == anew.keys()
    for name in ours:
        np.testing.assert_array_equal(ours[name], anew[name], err_msg=name)


def test_the_stage_shows_everything(stage, renderer):
    seen = frame(renderer, stage)
    names = {renderer.gprims[k].split("/")[2] for k in np.unique(seen["instance"]) if k >= 0}
    assert names == {"Ground", "Parted", "Balls", "Crates", "Points", "Varied", "Man"}
    assert {"direct_diffuse", "indirect_diffuse", "HdrColor"} <= {*seen}


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("name", sampled(ALL_EDITS, 12))
def test_after_an_edit_the_frame_is_that_of_a_new_renderer(name, stage, renderer):
    time = Usd.TimeCode(12)
    before = frame(renderer, stage, time)
    changed = False
    for k in range(1, 4):
        ALL_EDITS[name](stage, k)
        assert_fresh(renderer, stage, time)
        now = frame(renderer, stage)
        changed |= any(not np.array_equal(before[key], now[key]) for key in before)
    assert changed == (name != "a label"), "the edit is one that shows"


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("seed", sampled(range(4)))
def test_after_many_edits_the_frame_is_that_of_a_new_renderer(seed, stage, renderer):
    rng = np.random.default_rng(seed)
    names = [*ALL_EDITS]
    time = None
    for _ in range(30):
        for _ in range(rng.integers(1, 5)):
            ALL_EDITS[names[rng.integers(len(names))]](stage, int(rng.integers(100)))
        if rng.random() < 0.3:
            time = Usd.TimeCode(float(rng.integers(0, 25)))
        assert_fresh(renderer, stage, time)


def hide_or_show_any(stage, rng):
    """Toggle the visibility of a prim at any depth, in instances and prototypes too, and sometimes its purpose."""
    prims = [
        prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Imageable) and prim.GetName() not in ("World", "Camera")
    ]
    prim = UsdGeom.Imageable(prims[rng.integers(len(prims))])
    visibility = prim.CreateVisibilityAttr()
    visibility.Set("inherited" if visibility.Get() == "invisible" else "invisible")
    if rng.random() < 0.1:
        prim.CreatePurposeAttr().Set(["default", "proxy", "render"][rng.integers(3)])


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("seed", sampled(range(20), 3))
def test_what_is_edited_while_it_is_hidden_is_that_of_a_new_renderer(seed, stage, renderer):
    rng = np.random.default_rng(seed)
    names = [*ALL_EDITS]
    time = None
    for _ in range(12):
        for _ in range(rng.integers(0, 4)):
            hide_or_show_any(stage, rng)
        for _ in range(rng.integers(0, 3)):
            ALL_EDITS[names[rng.integers(len(names))]](stage, int(rng.integers(100)))
        if rng.random() < 0.2:
            time = Usd.TimeCode(float(rng.integers(0, 25)))
        assert_fresh(renderer, stage, time)
