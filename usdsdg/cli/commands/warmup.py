"""`usdsdg warmup`: compile all kernels ahead, so that no run has to."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path

import click

from usdsdg.cli.command import Command
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import (
    command_context,
    device_option,
    physics_device_option,
    quiet_option,
)
from usdsdg.errors import counted
from usdsdg.warp_start import quiet_warp, start_warp

# What Warp keeps for CPUs and for CUDA.
BINARIES = (".o", ".cubin", ".ptx")


@click.command(cls=Command, epilog=epilog("warmup"))
@device_option
@physics_device_option
@quiet_option
def warmup(device: str | None, physics_device: str, quiet: bool) -> None:
    """Compile all kernels ahead, for container images and clusters: runs then compile nothing.

    Kernels are kept in Warp's cache, WARP_CACHE_PATH if it is set. They are for this version of usdsdg, this kind of
    processor and GPU, and the device that runs will have. For example, in a Dockerfile:

    \b
    ENV WARP_CACHE_PATH=/opt/kernels
    RUN usdsdg warmup --device cpu
    """
    with command_context(device=device, physics_device=physics_device, quiet=quiet):
        import warp as wp

        quiet_warp()
        start_warp()
        assert wp.config.kernel_cache_dir is not None  # now it is set
        for line in compile_ahead(_rooms(device), Path(wp.config.kernel_cache_dir)):
            print(line, flush=True)


def compile_ahead(rooms: Mapping[str, Callable[[], object]], cache: Path) -> list[str]:
    """Call what compiles the kernels of each room, and return lines that say what came into the cache."""
    lines = []
    for name, compile_room in rooms.items():
        before, began = _binaries(cache), time.monotonic()
        compile_room()
        if new := len(_binaries(cache) - before):
            lines.append(f"{name} kernels: {counted(new, 'module')} compiled in {time.monotonic() - began:.0f} s")
    return [*(lines or ["nothing to compile"]), f"kernel cache: {cache}"]


def _binaries(cache: Path) -> set[Path]:
    return {file for file in cache.glob("wp_*/*") if file.suffix in BINARIES}


def _rooms(device: str | None) -> dict[str, Callable[[], object]]:
    """Return what compiles the kernels of each room, on the devices where runs with these options have them."""
    import usdsdg_physics
    from usdsdg.session.devices.choice import physics_device
    from usdsdg.session.progress import report
    from usdsdg_render.device.precompile import precompile
    from usdsdg_render.renderer import chosen_device

    renders_on = chosen_device(device)
    return {
        "render": lambda: precompile(renders_on, report, everything=True),
        "physics": lambda: usdsdg_physics.precompile(device=physics_device(), progress=report),
        "annotator": lambda: _load_pixel_kernels(renders_on, report),
    }


def _load_pixel_kernels(device: str, progress: Callable[[str, int, int | None], None]) -> None:
    """Load the kernels of annotators, for images on the device and in the memory of the host, and those of writers."""
    import warp as wp

    from usdsdg.kernels.compilation import ModuleLoad, kernel_modules, load_modules
    from usdsdg.parallel import CUDA_BLOCK, available_threads

    modules = kernel_modules("usdsdg.annotators")
    loads = [ModuleLoad(module, wp.get_device("cpu")) for module in [*modules, *kernel_modules("usdsdg.writers")]]
    if wp.get_device(device).is_cuda:
        loads += [ModuleLoad(module, wp.get_device(device), CUDA_BLOCK) for module in modules]
    load_modules(loads, what="annotator kernels", threads=available_threads(), progress=progress)
