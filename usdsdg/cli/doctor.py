"""`usdsdg doctor`: print installed packages, devices, and the folders of caches and assets."""

import importlib.metadata
import logging
import platform
import shutil
from pathlib import Path

from usdsdg.cli.command_context import command_context
from usdsdg.operating_system import usable_cores

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
    "typer",
    "rich",
]
OPTIONAL = {
    "OpenEXR": "reads .exr skies and textures",
    "obstore": "writes to buckets and brings assets from URLs",
    "mitsuba-oidn": "denoises path-traced images with Open Image Denoise",
}


def doctor() -> None:
    """Print installed packages, devices, the folders of caches and assets, and what is missing."""
    with command_context(quiet=True):
        missing = [*_packages(), *_devices(), *_denoiser(), *_folders()]
    print()
    print("Nothing is missing." if not missing else "Missing:\n" + "\n".join(f"  {line}" for line in missing))


def _packages() -> list[str]:
    import usdsdg

    missing = []
    print(f"usdsdg {usdsdg.__version__}, Python {platform.python_version()}, {platform.platform()}")
    for name in REQUIRED:
        try:
            print(f"  {name:12} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            missing.append(f"{name}: pip install {name}")
    for name, use in OPTIONAL.items():
        try:
            print(f"  {name:12} {importlib.metadata.version(name)} (optional)")
        except importlib.metadata.PackageNotFoundError:
            print(f"  {name:12} not installed (optional: {use}; pip install {name})")
    return missing


def _devices() -> list[str]:
    import warp as wp

    wp.config.log_level = logging.WARNING
    wp.init()
    print("\ndevices")
    print(f"  cpu          {usable_cores()} cores, {platform.machine()}")
    for device in wp.get_cuda_devices():
        print(f"  {device.alias:12} {device.name}, {device.total_memory / 2**30:.1f} GiB, sm_{device.arch}")
    if not wp.get_cuda_devices():
        print("  cuda         no device or no driver: everything runs on the CPU")
    return []


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
