"""The built-in assets root as a folder in the user's cache: made once, whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from usdsdg.errors import AssetError

# Raise it whenever a stand-in looks different, so that old folders are left behind.
EDITION = 3


def root() -> str:
    """Folder with stand-ins under Isaac Sim's relative paths; built on first use in about three seconds.

    It lies in `$XDG_CACHE_HOME/usdsdg` (default `~/.cache/usdsdg`). Several processes may ask at once: each
    builds its own copy and the first to finish is kept.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    target = _target()
    if not target.is_dir():
        try:
            _build_beside(target)
        except OSError as error:
            raise AssetError(
                f"The built-in demo assets cannot be written to {target}: {error}. Free space or permissions there, "
                "or set XDG_CACHE_HOME to a writable folder, or configure an assets root of your own."
            ) from error
    return str(target)


def build(folder: Path) -> None:
    """Make every stand-in below `folder`, which must exist."""
    from usdsdg.demo import catalogue
    from usdsdg.demo.props import hall

    with ThreadPoolExecutor(max_workers=2) as pool:
        skies = [pool.submit(_write_sky, _below(folder, url), room) for url, room in catalogue.PANORAMAS.items()]
        _write_assets(folder)
        hall.write_warehouse(_below(folder, catalogue.HALL))
        for sky in skies:
            sky.result()


def _target() -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    try:
        release = version("usdsdg")
    except PackageNotFoundError:
        release = "source"
    return Path(cache) / "usdsdg" / f"demo-{release}-{EDITION}"


def _build_beside(target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        build(draft)
        draft.chmod(0o755)
        draft.rename(target)
    except OSError:
        # Another process was faster: its folder is as good as this one.
        if not target.is_dir():
            raise
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _write_assets(folder: Path) -> None:
    from usdsdg.demo import catalogue, layer

    for url, make in catalogue.PROPS.items():
        layer.write_asset(_below(folder, url), make())
    for name, make in catalogue.GROCERIES.items():
        asset = make()
        plain = _below(folder, f"{catalogue.YCB}/{name}")
        layer.write_asset(plain, asset)
        if asset.mass is None:
            raise AssertionError(f"{name} needs a mass for its physics variant")
        layer.write_physics_variant(_below(folder, f"{catalogue.YCB_PHYSICS}/{name}"), plain, asset.mass)


def _write_sky(path: Path, room) -> None:
    from usdsdg.demo.skies.panorama import panorama
    from usdsdg.stage.image_files.radiance_writer import write_hdr

    path.parent.mkdir(parents=True, exist_ok=True)
    write_hdr(path, panorama(room()))


def _below(folder: Path, url: str) -> Path:
    return folder / url.lstrip("/")
