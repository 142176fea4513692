"""Kernels are loaded for convex shapes, and again when triangle meshes first come; progress is of compiling them."""

import numpy as np
import pytest
import warp as wp
from pxr import UsdPhysics

from tests.physics.scenes import add, mesh, new_stage
from usdsdg.kernels.compilation import ModuleLoad
from usdsdg_physics import NewtonEngine
from usdsdg_physics.world import compile_kernels


@pytest.fixture
def nothing_loaded(monkeypatch):
    monkeypatch.setattr(compile_kernels, "_loaded", set())


@pytest.fixture
def nothing_cached(monkeypatch):
    """Modules count as compiled when they are loaded, though Warp's cache may have them."""
    monkeypatch.setattr(ModuleLoad, "is_cached", lambda _: False)


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


def test_meshes_after_convex_shapes_load_their_kernels_with_progress(nothing_loaded, nothing_cached):
    first = _reports(with_mesh=False)
    assert first[0][0].startswith("compiling physics kernels (first use)")
    assert (first[0][1:], first[-1][1:]) == ((0, 100), (100, 100))
    assert not _reports(with_mesh=False)
    assert _reports(with_mesh=True)[-1][1:] == (100, 100)
    assert not _reports(with_mesh=True)


def test_meshes_at_once_load_everything(nothing_loaded, nothing_cached):
    assert _reports(with_mesh=True)
    assert not _reports(with_mesh=False)


def test_kernels_in_the_cache_are_loaded_without_a_word(monkeypatch):
    _reports(with_mesh=True)  # compiled now, if not before
    monkeypatch.setattr(compile_kernels, "_loaded", set())
    assert not _reports(with_mesh=True)


@pytest.mark.parametrize("with_mesh", [False, True])
def test_the_narrow_phase_is_found_before_it_is_launched(with_mesh, nothing_loaded, monkeypatch):
    """What a first step launches of it was loaded ahead, where it compiles beside the others."""
    ahead, launched = set(), set()
    load = ModuleLoad.run
    monkeypatch.setattr(ModuleLoad, "run", lambda self: (ahead.add(self.module.name), load(self)))
    launch = wp.launch

    def noting(kernel, *arguments, **options):
        launched.add(kernel.module.name)
        return launch(kernel, *arguments, **options)

    monkeypatch.setattr(wp, "launch", noting)
    _reports(with_mesh=with_mesh)
    narrow = {name for name in launched if "narrow_phase" in name}
    assert narrow
    assert narrow <= ahead


@pytest.mark.parametrize("shapes", [64, 128, 129, 256, 257, 512])
def test_the_sorts_of_the_broad_phase_are_known_ahead(shapes):
    from newton._src.geometry.broad_phase_sap import BroadPhaseSAP

    broad_phase = BroadPhaseSAP(np.full(shapes, -1, np.int32), sort_type="auto", device="cpu")
    kernel, block = broad_phase.tile_sort_kernel, broad_phase.tile_block_dim
    assert kernel is not None
    found = compile_kernels.sort_modules()[block].get_module_identifier(block)
    assert kernel.module.get_module_identifier(block) == found
