"""Build the demo assets in the user's cache folder: once, and atomically."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

from usdsdg.errors import AssetError
from usdsdg.stage.assets import cache_folder

if TYPE_CHECKING:
    from usdsdg.demo.skies.room import Room

# Increase it whenever an asset changes, so that cached folders of older editions are no longer used.
EDITION = 3


def root() -> str:
    """Return the folder of the demo assets, laid out like Isaac Sim's; built on first use in about three seconds.

    It is in `$XDG_CACHE_HOME/usdsdg` (default `~/.cache/usdsdg`). Processes that build at the same time each make
    a copy of their own, and the first one to finish is kept.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    target = _target()
    if not target.is_dir():
        try:
            _build_and_rename(target)
        except OSError as error:
            raise AssetError(
                f"The built-in demo assets cannot be written to {target}: {error}. Free space or permissions there, "
                "or set XDG_CACHE_HOME to a writable folder, or configure an assets root of your own."
            ) from error
    return str(target)


def build(folder: Path) -> None:
    """Write every demo asset below `folder`, which must exist."""
    from usdsdg.demo import asset_urls
    from usdsdg.demo.props import warehouse_hall

    with ThreadPoolExecutor(max_workers=2) as pool:
        skies = [pool.submit(_write_sky, _below(folder, url), room) for url, room in asset_urls.PANORAMAS.items()]
        _write_assets(folder)
        warehouse_hall.write_warehouse(_below(folder, asset_urls.WAREHOUSE_STAGE))
        for sky in skies:
            sky.result()


def _target() -> Path:
    try:
        release = version("usdsdg")
    except PackageNotFoundError:
        release = "source"
    return cache_folder() / f"demo-{release}-{EDITION}"


def _build_and_rename(target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    try:
        build(temporary)
        temporary.chmod(0o755)
        temporary.rename(target)
    except OSError:
        # Another process may have finished first; its folder has the same contents.
        if not target.is_dir():
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _write_assets(folder: Path) -> None:
    from usdsdg.demo import asset_urls, usd_writer

    for url, make in asset_urls.PROPS.items():
        usd_writer.write_asset(_below(folder, url), make())
    for name, make in asset_urls.GROCERIES.items():
        asset = make()
        visual = _below(folder, f"{asset_urls.YCB}/{name}")
        usd_writer.write_asset(visual, asset)
        if asset.mass is None:
            raise AssertionError(f"{name} needs a mass for its physics variant")
        usd_writer.write_physics_variant(_below(folder, f"{asset_urls.YCB_PHYSICS}/{name}"), visual, asset.mass)


def _write_sky(path: Path, make_room: Callable[[], Room]) -> None:
    from usdsdg.demo.skies.panorama import panorama
    from usdsdg.stage.image_files import radiance_hdr

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(radiance_hdr.encode(panorama(make_room())))


def _below(folder: Path, url: str) -> Path:
    return folder / url.lstrip("/")
