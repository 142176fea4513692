"""`usdsdg doctor`: print packages, devices and folders, what is missing, and what would make this machine faster."""

import importlib.metadata
import os
import platform
import shutil
import tempfile
from pathlib import Path

import click

from usdsdg.cli.command import Command
from usdsdg.cli.examples import epilog
from usdsdg.cli.machine_advice import Machine, advice, gpu_line
from usdsdg.cli.options.command_context import command_context
from usdsdg.operating_system import usable_cores
from usdsdg.warp_start import cuda_driver_version, has_nvidia_gpu, quiet_warp, start_warp

REQUIRED = [
    "usd-core",
    "warp-lang",
    "newton",
    "numpy",
    "scipy",
    "trimesh",
    "pillow",
    "coacd",
    "pyyaml",
    "pydantic",
    "click",
]
# Package -> (the extra that installs it, what it does).
OPTIONAL = {
    "OpenEXR": ("exr", "reads .exr skies and textures"),
    "obstore": ("stores", "writes to buckets and brings assets from URLs"),
    "mitsuba-oidn": ("denoise", "denoises path-traced images with Open Image Denoise"),
    "assimp-py": ("meshes", "reads FBX, URDF and COLLADA"),
    "pyarrow": ("parquet", "writes Parquet tables"),
    "rerun-sdk": ("rerun", "records jobs for the Rerun viewer"),
    "ray": ("ray", "makes parts of a dataset on a cluster"),
    "uvicorn": ("view", "serves the page of usdsdg view"),
}


@click.command(cls=Command, epilog=epilog("doctor"))
def doctor() -> None:
    """Print installed packages, devices, folders, what is missing, and what would make this machine faster."""
    with command_context(quiet=True):
        missing = _packages()
        machine = _machine()
        _print_devices(machine)
        missing += [*_denoiser(), *_folders()]
        faster = advice(machine)
    print()
    print("Nothing is missing." if not missing else "Missing:\n" + "\n".join(f"  {line}" for line in missing))
    print("Nothing here would be faster." if not faster else "\n".join(["Faster:", *(f"  {line}" for line in faster)]))


def _packages() -> list[str]:
    import usdsdg

    missing = []
    print(f"usdsdg {usdsdg.__version__}, Python {platform.python_version()}, {platform.platform()}")
    for name in REQUIRED:
        if version := _version(name):
            print(f"  {name:12} {version}")
        else:
            missing.append(f"{name}: pip install {name}")
    for name, (extra, use) in OPTIONAL.items():
        if version := _version(name):
            print(f"  {name:12} {version} (optional)")
        else:
            print(f"  {name:12} not installed (optional: {use}; pip install 'usdsdg[{extra}]')")
    return missing


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _machine() -> Machine:
    """Look at the machine; this starts Warp."""
    import warp as wp

    quiet_warp()
    start_warp()
    devices = wp.get_cuda_devices()
    cache = Path(wp.config.kernel_cache_dir or "")
    return Machine(
        cores=usable_cores(), all_cores=os.cpu_count() or 1, has_gpu=has_nvidia_gpu(), driver=cuda_driver_version(),
        needed_driver=((wp.get_cuda_toolkit_version() or (12, 0))[0], 0),  # any minor version will do
        cuda_devices=len(devices),
        hidden_devices=os.environ.get("CUDA_VISIBLE_DEVICES"), has_denoiser=_version("mitsuba-oidn") is not None,
        cache=str(cache), can_write_cache=_can_write(cache), cold_modules=_cold_modules(),
    )  # fmt: skip


def _cold_modules() -> int:
    from usdsdg_render.device.precompile import cold_modules
    from usdsdg_render.renderer import chosen_device

    return len(cold_modules(chosen_device(None)))


def _can_write(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _print_devices(machine: Machine) -> None:
    import warp as wp

    print("\ndevices")
    print(f"  cpu          {machine.cores} cores, {platform.machine()}")
    for device in wp.get_cuda_devices():
        print(f"  {device.alias:12} {device.name}, {device.total_memory / 2**30:.1f} GiB, sm_{device.arch}")
    if line := gpu_line(machine):
        print(f"  cuda         {line}")


def _denoiser() -> list[str]:
    """Return why an installed Open Image Denoise cannot load: it needs a system library that no package provides."""
    from usdsdg.errors import RenderError
    from usdsdg_render.path import oidn_denoiser

    try:
        if oidn_denoiser.is_installed():
            oidn_denoiser.library()
    except RenderError as error:
        return [str(error)]
    return []


def _folders() -> list[str]:
    import warp as wp

    from usdsdg.errors import AssetError
    from usdsdg.session.stage_context import assets_root

    print("\nfolders")
    assert wp.config.kernel_cache_dir is not None  # wp.init() sets it
    _folder("kernel cache", Path(wp.config.kernel_cache_dir))
    try:
        _folder("assets root", Path(assets_root()))
    except AssetError as error:
        return [str(error)]
    return []


def _folder(name: str, path: Path) -> None:
    free = shutil.disk_usage(path if path.exists() else path.parent).free / 2**30
    print(f"  {name:12} {path} ({free:.0f} GiB free)")
