"""Build the demo assets in the user's cache folder: once, and atomically."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

from usdsdg.errors import AssetError
from usdsdg.stage.assets import built_folder, cache_folder

if TYPE_CHECKING:
    from usdsdg.demo.skies.room import Room

# Increase it whenever an asset changes, so that cached folders of older editions are no longer used.
EDITION = 5
PARTS_EDITION = 1
GRID_EDITION = 1
EXAMPLES_EDITION = 1
_GRID = "default_environment.usd"


def root() -> str:
    """Return the folder of the demo assets, laid out like Isaac Sim's; built on first use in about three seconds.

    It is in `$XDG_CACHE_HOME/usdsdg` (default `~/.cache/usdsdg`). Processes that build at the same time each make
    a copy of their own, and the first one to finish is kept.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    return _built(f"demo-{_release()}-{EDITION}", build, "built-in demo assets", "configure an assets root of your own")


def machine_parts() -> str:
    """Return the folder of the demo parts of bin picking, one USD file each; built on first use.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    return _built(f"parts-{_release()}-{PARTS_EDITION}", _write_parts, "demo parts", "name a folder of your own meshes")


def example_assets() -> str:
    """Return the folder of the assets of `rep.example`, one USD file each; built on first use.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    return _built(
        f"examples-{_release()}-{EXAMPLES_EDITION}", _write_examples, "example assets", "name files of your own"
    )


def grid_environment() -> str:
    """Return the USD file of the demo ground, for roots without a grid environment; built on first use.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    folder = _built(f"grid-{_release()}-{GRID_EDITION}", _write_grid, "demo ground", "add one to the assets root")
    return str(Path(folder) / _GRID)


def _built(name: str, build: Callable[[Path], None], what: str, instead: str) -> str:
    target = cache_folder() / name
    try:
        return str(built_folder(target, build))
    except OSError as error:
        raise AssetError(
            f"The {what} cannot be written to {target}: {error}. Free space or permissions there, or set "
            f"XDG_CACHE_HOME to a writable folder, or {instead}."
        ) from error


def build(folder: Path) -> None:
    """Write every demo asset below `folder`, which must exist."""
    from usdsdg.demo import asset_urls
    from usdsdg.demo.props import grid_environment, warehouse_hall

    with ThreadPoolExecutor(max_workers=2) as pool:
        skies = [pool.submit(_write_sky, _below(folder, url), room) for url, room in asset_urls.PANORAMAS.items()]
        _write_assets(folder)
        warehouse_hall.write_warehouse(_below(folder, asset_urls.WAREHOUSE_STAGE))
        grid_environment.write_grid(_below(folder, asset_urls.GRID_STAGE))
        for sky in skies:
            sky.result()


@cache
def _release() -> str:
    try:
        return version("usdsdg")
    except PackageNotFoundError:
        return "source"


def _write_parts(folder: Path) -> None:
    from usdsdg.demo import usd_writer
    from usdsdg.demo.props import machine_parts

    for name, make in machine_parts.PARTS.items():
        usd_writer.write_asset(folder / f"{name}.usd", make())


def _write_examples(folder: Path) -> None:
    from usdsdg.demo.props.color_variants import write_color_variants

    _write_parts(folder)
    write_color_variants(folder / "variant.usd")


def _write_grid(folder: Path) -> None:
    from usdsdg.demo.props.grid_environment import write_grid

    write_grid(folder / _GRID)


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
    from usdsdg.image_files import radiance_hdr

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(radiance_hdr.encode(panorama(make_room())))


def _below(folder: Path, url: str) -> Path:
    return folder / url.lstrip("/")
