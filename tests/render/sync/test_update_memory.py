"""Hundreds of frames in which textures, prims, shapes and skies come and go leave nothing behind."""

from __future__ import annotations

import ctypes
import gc
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, UsdGeom

from tests.render.sync.changing_stage import EDITS, make_stage
from tests.sampled_cases import in_soak
from usdsdg_render.geometry import prototypes
from usdsdg_render.images import textures
from usdsdg_render.renderer import WarpRenderer

FRAMES, WARM = 600, 300
STATM = Path("/proc/self/statm")


def resident() -> float:
    """Megabytes of this process that are in memory, without what the C library holds back for later."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(STATM.read_text().split()[1]) * 4096 / 1e6


@in_soak
@pytest.mark.skipif(not STATM.exists(), reason="asks Linux how much memory the process has")
@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
def test_frames_leave_nothing_behind(tmp_path, monkeypatch):
    # What is idle is kept up to a size, on purpose; here it is small, so that it is full soon.
    monkeypatch.setattr(textures, "MAX_IDLE_BYTES", 20 << 20)
    monkeypatch.setattr(prototypes, "MAX_IDLE_TRIANGLES", 50_000)
    stage = make_stage(tmp_path)
    renderer = WarpRenderer(stage, device="cpu")
    rng = np.random.default_rng(0)
    image = stage.GetAttributeAtPath("/World/Looks/textured/Tex.inputs:file")
    names = ("a reference", "a label", "the sky's image", "the sky's color", "colors of points", "a variant")
    memory = []
    for k in range(FRAMES):
        file = tmp_path / f"new_{k}.png"
        Image.fromarray(rng.integers(0, 256, (128, 128, 3), np.uint8)).save(file)
        image.Set(str(file))
        stage.RemovePrim(f"/World/New{k - 1}")
        ball = UsdGeom.Sphere.Define(stage, f"/World/New{k}")
        ball.CreateRadiusAttr(0.1 + 0.0001 * k)
        mesh = stage.GetAttributeAtPath("/World/Parted.points")
        mesh.Set([point * (1 + 0.001 * (k % 7)) + Gf.Vec3f(0, 0, 1e-4 * k) for point in mesh.Get()])
        for name in names:
            EDITS[name](stage, k)
        renderer.sync()
        if k >= WARM and k % 100 == 99:
            memory.append(resident())
    # 64 KiB of each texture and 900 KiB of each ball would be 290 MB.
    assert memory[-1] - memory[0] < 15, memory
