"""Kernels are loaded with progress: once for convex shapes, and once more when triangle meshes first come."""

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.scenes import add, mesh, new_stage
from usdsdg_physics import NewtonEngine
from usdsdg_physics.world import compile_kernels


@pytest.fixture
def nothing_loaded(monkeypatch):
    monkeypatch.setattr(compile_kernels, "_loaded", set())


def _reports(*, with_mesh):
    stage = new_stage()
    add(stage, "/World/box", at=(0, 0, 2))
    if with_mesh:
        ground = mesh(
            stage, "/World/ground", np.array([(-5, -5, 0), (5, -5, 0), (0, 5, 0)], float), np.array([[0, 1, 2]])
        )
        UsdPhysics.CollisionAPI.Apply(ground.GetPrim())
    heard = []
    engine = NewtonEngine(stage, device="cpu", progress=lambda label, done, total: heard.append((label, done, total)))
    engine.play()
    engine.step(1 / 60)
    return heard


def test_meshes_after_convex_shapes_load_their_kernels_with_progress(nothing_loaded):
    first = _reports(with_mesh=False)
    assert first[-1] == (compile_kernels.LABEL, first[-1][2], first[-1][2])
    assert not _reports(with_mesh=False)
    assert _reports(with_mesh=True) == [(compile_kernels.LABEL, 0, 1), (compile_kernels.LABEL, 1, 1)]
    assert not _reports(with_mesh=True)


def test_meshes_at_once_load_everything(nothing_loaded):
    assert len(_reports(with_mesh=True)) > 3
    assert not _reports(with_mesh=False)
