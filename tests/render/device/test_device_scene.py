"""Device tables follow the scene, and kernels compile for devices that are not present."""

from __future__ import annotations

import importlib
import json
import pkgutil
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp

import usdsdg_render
from tests import forked
from tests.render import scenes
from tests.render.images import radiance, renderer_of
from tests.sampled_cases import sampled
from usdsdg.errors import RenderError
from usdsdg.kernels.compilation import ModuleLoad
from usdsdg_render.device.precompile import module_loads, precompile, without_bfloat16
from usdsdg_render.kernels.labels import label_kernels
from usdsdg_render.kernels.path import wavefront
from usdsdg_render.lights.environment import packed, packing_unit, to_grid
from usdsdg_render.renderer import chosen_device
from usdsdg_render.scene.scene import Instances, Texture
from usdsdg_render.settings import PathSettings

VIEW = scenes.view_from((0, -6, 0), size=(24, 18))


def two_cubes():
    placed = [(scenes.cube(), scenes.moved((x, 0, 0), scale=0.5), 0) for x in (-1.5, 1.5)]
    return scenes.scene_of(placed, materials=[scenes.material(base_color=0.5)], dome=scenes.white_dome())


def columns_of(labels, index) -> np.ndarray:
    return np.nonzero((labels["instance"] == index).any(0))[0]


def test_only_changed_tables_are_uploaded():
    scene = two_cubes()
    renderer = renderer_of(scene)
    # Without a new version nothing is uploaded.
    scene.instances.local_to_world[0, 3, 0] = 50.0
    renderer.sync()
    assert len(columns_of(renderer.labels(VIEW, ["instance"]), 0)) > 0
    scene.touch("transforms")
    renderer.sync()
    assert len(columns_of(renderer.labels(VIEW, ["instance"]), 0)) == 0
    scene.materials["base_color"] = (1, 0, 0)
    scene.touch("materials")
    renderer.sync()
    albedo = renderer.labels(VIEW, ["instance", "albedo"])
    np.testing.assert_allclose(
        albedo["albedo"][albedo["instance"] == 1], [[1, 0, 0]] * int((albedo["instance"] == 1).sum()), atol=1e-6
    )


def test_instances_prototypes_and_textures_are_replaced():
    scene = two_cubes()
    renderer = renderer_of(scene)
    ball = scenes.sphere(rings=16)
    scene.prototypes = [ball]
    scene.textures = [Texture("red", np.full((1, 1, 4), (255, 0, 0, 255), np.uint8), False, 0, 0)]
    scene.materials["base_color_texture"] = 0
    scene.instances = Instances(
        ("/ball",), np.zeros(1, np.int32), scenes.moved()[None], np.zeros(1, np.int32), np.ones(1, np.int32)
    )
    scene.touch("prototypes", "instances", "transforms", "materials", "textures")
    renderer.sync()
    labels = renderer.labels(VIEW, ["instance", "albedo"])
    assert renderer.gprims == ("/ball",)
    assert set(np.unique(labels["instance"])) == {-1, 0}
    np.testing.assert_allclose(labels["albedo"][9, 12], (0.5, 0, 0), atol=1e-6)
    scene.instances = Instances()
    scene.touch("instances", "transforms")
    renderer.sync()
    assert (renderer.labels(VIEW, ["instance"])["instance"] == -1).all()


def test_lights_and_domes_are_updated():
    scene = two_cubes()
    renderer = renderer_of(scene)

    def brightness() -> float:
        film = renderer.new_film(24, 18)
        renderer.accumulate(film, VIEW, samples=4, settings=PathSettings())
        return float(film.radiance().mean())

    before = brightness()
    scene.dome = scenes.white_dome(2.0)
    scene.touch("dome")
    renderer.sync()
    assert brightness() == pytest.approx(2 * before, rel=1e-3)
    scene.dome, scene.lights = None, scenes.distant_light(5.0, (0, 1, 0))
    scene.touch("dome", "lights")
    renderer.sync()
    assert 0 < brightness() < before


def test_packed_environments_have_a_relative_error_below_one_in_five_hundred():
    rng = np.random.default_rng(0)
    radiance_in = (rng.uniform(0, 1, (16, 32, 3)) * 10.0 ** rng.uniform(-3, 5, (16, 32, 1))).astype(np.float32)
    unit = packing_unit(radiance_in)
    words = packed(radiance_in, unit)
    exponent = (words >> 27).astype(int)
    out = np.stack([words >> shift & 511 for shift in (0, 9, 18)], -1) * (unit * 2.0**exponent)[..., None]
    error = np.abs(out - radiance_in).max(-1) / radiance_in.max(-1)
    assert error.max() < 1 / 500


@pytest.mark.parametrize("shape", [(8, 16), (100, 333), (512, 1024), (700, 1500)])
def test_resampled_environments_keep_their_energy(shape):
    rng = np.random.default_rng(1)
    environment = rng.uniform(0, 1, (*shape, 3)).astype(np.float32)

    def energy(image: np.ndarray) -> float:
        rows = len(image)
        edges = np.cos(np.pi * np.arange(rows + 1) / rows)
        return float((image.mean(1) * (edges[:-1] - edges[1:])[:, None]).sum())

    np.testing.assert_allclose(energy(to_grid(environment)), energy(environment), rtol=0.02)
    assert to_grid(environment).shape == (256, 512, 3)


def test_images_do_not_depend_on_scale_and_distance_from_the_origin():
    def rendered(scale: float, offset) -> np.ndarray:
        offset = np.asarray(offset, float)
        placed = [
            (scenes.sphere(rings=24), scenes.moved(offset + np.array([0, 0, scale]), scale=scale), 0),
            (scenes.square(), scenes.moved(offset, scale=5 * scale), 0),
        ]
        scene = scenes.scene_of(
            placed, materials=[scenes.material(base_color=0.7)], lights=[scenes.distant_light(3.0, (1, 1, -1))],
            dome=scenes.white_dome(0.5),
        )  # fmt: skip
        eye = offset + np.array([3, -5, 3]) * scale
        view = scenes.view_from(
            eye, offset + np.array([0, 0, 0.5 * scale]), size=(32, 24), clipping_range=(scale * 1e-2, scale * 1e3)
        )
        return radiance(scene, view, samples=64)

    reference = rendered(1.0, (0, 0, 0))
    for scale, offset in ((1e-3, (0, 0, 0)), (1e3, (0, 0, 0)), (1.0, (800, -500, 20)), (1e-2, (3, 2, 1))):
        # Self-shadowing or light leaks would change the mean of some region.
        blocks = [p.reshape(4, 6, 4, 8, 3).mean((1, 3)) for p in (rendered(scale, offset), reference)]
        np.testing.assert_allclose(blocks[0], blocks[1], rtol=0.03)


def test_unknown_devices_are_named():
    with pytest.raises(RenderError, match="Devices here: cpu"):
        chosen_device("cuda:9")


def test_precompiling_reports_what_is_not_in_the_cache(monkeypatch):
    from usdsdg_render.device import precompile as module

    reports = []
    precompile("cpu")  # compiled now, if not before
    module._ready.clear()
    precompile("cpu", lambda *_: pytest.fail("all is in the cache"))
    module._ready.clear()
    monkeypatch.setattr(ModuleLoad, "is_cached", lambda _: False)
    precompile("cpu", lambda label, done, total: reports.append((label, done, total)))
    assert reports[0][0].startswith("compiling render kernels (first use)")
    assert (reports[0][1:], reports[-1][1:]) == ((0, 100), (100, 100))
    precompile("cpu", lambda *_: pytest.fail("already compiled"))


def test_a_cuda_host_compiles_for_its_cpu_only_what_runs_there():
    """And on CUDA the modules only for the blocks that they are launched with."""
    cuda: Any = SimpleNamespace(is_cuda=True, is_cpu=False)
    loads = module_loads(cuda, everything=True)
    on_cpu = {load.module.name.rpartition(".")[2] for load in loads if load.device is not cuda}
    assert on_cpu == {"build", "compress", "forest", "instance_transforms", "run_kernels"}
    blocks = {load.module.name.rpartition(".")[2]: load.block for load in loads if load.device is cuda}
    assert blocks == {
        "wavefront": 128, "label_module": 64, "wavelet_denoiser": 64, "tone_map": 64, "parts": 64, "label_boxes": 64,
    }  # fmt: skip


def test_every_kernel_of_the_renderer_is_in_a_module_that_is_compiled_ahead():
    targets: list[Any] = [wp.get_device("cpu"), SimpleNamespace(is_cuda=True, is_cpu=False)]
    ahead = {load.module for target in targets for load in module_loads(target, everything=True)}
    names = [each.name for each in pkgutil.walk_packages(usdsdg_render.__path__, "usdsdg_render.")]
    found = [each for name in names for each in vars(importlib.import_module(name)).values()]
    assert {each.module.name for each in found if isinstance(each, wp.Kernel)} <= {each.name for each in ahead}


# Prints where Warp keeps each module of the renderer, after those of all scenes, or of most, are said to be compiled.
PLACES = """
import json, sys
from usdsdg_render.device import precompile
from usdsdg.kernels import cache
from usdsdg.warp_start import quiet_warp, start_warp
import warp as wp
quiet_warp()
start_warp()
precompile.load_modules = lambda *_, **__: []
precompile.precompile("cpu", everything=sys.argv[1] == "everything")
loads = precompile.module_loads(wp.get_device("cpu"), everything=True)
print(json.dumps({load.module.name: cache._folder(load.module, 1) for load in loads}))
"""


def test_what_is_compiled_ahead_for_some_scenes_is_what_they_load():
    """Options of a module are part of its name in the cache."""
    places = [
        json.loads(forked.run(["-c", PLACES, which], cwd=forked.ROOT, fresh=True).stdout.splitlines()[-1])
        for which in ("everything", "most")
    ]
    assert places[0] == places[1]


def test_kernels_of_one_module_are_launched_with_one_size_of_blocks(monkeypatch):
    """On CUDA each size is another variant of the module, compiled by itself: sources name all sizes."""
    for file in Path(usdsdg_render.__file__).parent.rglob("*.py"):
        for call in re.findall(r"wp\.launch\(.*?\)\n", file.read_text(encoding="utf-8"), re.DOTALL):
            assert 'device="cpu"' in call or re.search(r"block_dim=(CUDA_BLOCK|wavefront\.BLOCK)", call), (file, call)


@pytest.mark.parametrize(("flags", "kept"), [(None, "-march=native"), ("", ""), ("-O1", "-O1")])
def test_kernels_keep_the_compiler_flags_of_the_user(flags, kept, monkeypatch):
    monkeypatch.setattr(wp.config, "cpu_compiler_flags", flags)
    module = wp.get_module(f"flags {flags}")
    for _ in range(2):
        without_bfloat16(module)
        assert wp.get_module_options(module)["cpu_compiler_flags"] == f"{kept} -DWP_NO_BFLOAT16="


def test_kernels_compile_for_cuda(tmp_path):
    """Compile for Hopper with the compiler in Warp; no device is needed."""
    for kernel in sampled([wavefront.intersect_closest, label_kernels.label_pixels]):
        compiled = wp.compile_aot_module(kernel.module, arch=90, module_dir=tmp_path / kernel.key, use_ptx=True)
        assert any(file.stat().st_size > 1000 for file in compiled)
