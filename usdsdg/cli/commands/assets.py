"""`usdsdg assets get | list | check`: the copy of an assets root that is a URL, and of single assets."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click
from click.exceptions import Exit

from usdsdg.cli.command import Group, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import assets_root_option, command_context, quiet_option
from usdsdg.errors import ConfigError, counted

if TYPE_CHECKING:
    from usdsdg.mirror.root_mirror import RootMirror


@click.group(cls=Group)
def assets() -> None:
    """Copy assets of a root that is a URL to this machine, and check the copy."""


@assets.command(epilog=epilog("assets get"))
@argument("urls", nargs=-1, required=True, metavar="URL...", help="Files, as /Isaac/Props/cup.usd, or URLs.")
@assets_root_option
@quiet_option
def get(urls: tuple[str, ...], assets_root: str | None, quiet: bool) -> None:
    """Copy files with all that they refer to: layers, payloads, textures and materials."""
    with command_context(assets_root=assets_root, quiet=quiet):
        from usdsdg.stage.assets import is_remote, locate

        if not all(map(is_remote, urls)):
            _mirror()
        for url in urls:
            print(locate(url))


@assets.command(name="list", epilog=epilog("assets list"))
@assets_root_option
def list_(assets_root: str | None) -> None:
    """Print each file that has been copied, with its size and the beginning of its SHA-256."""
    with command_context(assets_root=assets_root, quiet=True):
        mirror = _mirror()
        records = mirror.records()
        for record in records:
            print(f"{record.sha256[:12]} {record.size:>12,} {record.path}")
        size = sum(record.size for record in records)
        print(f"{counted(len(records), 'file')} of {mirror.url}, {size / 1e6:,.1f} MB, in {mirror.folder}")


@assets.command(epilog=epilog("assets check"))
@assets_root_option
@click.option("--repair", is_flag=True, help="Copy damaged files again.")
@quiet_option
def check(assets_root: str | None, repair: bool, quiet: bool) -> None:
    """Read every copied file and compare it with the hash of its download; exit with 1 where one is damaged."""
    with command_context(assets_root=assets_root, quiet=quiet):
        mirror = _mirror()
        damaged = mirror.damaged()
        for record, damage in damaged:
            print(f"{record.path}: {damage}", file=sys.stderr)
            if repair:
                mirror.drop(record)
        for record, _ in damaged if repair else ():
            mirror.fetch(record.path)
        count = len(mirror.records())
        print(f"{counted(count, 'file')}, {len(damaged)} damaged{' and copied again' if repair and damaged else ''}")
        if damaged and not repair:
            raise Exit(1)


def _mirror() -> RootMirror:
    """Return the mirror of the configured root.

    Raises:
        ConfigError: the root is a folder, or none is set.
    """
    from usdsdg.mirror.root_mirror import RootMirror
    from usdsdg.stage.assets import configured_root, root_mirror

    mirror = root_mirror()
    if not isinstance(mirror, RootMirror):
        root = configured_root()
        where = f"{root} is a folder" if root else "none is set"
        raise ConfigError(f"the assets root is no URL ({where}), so nothing is copied. Give --assets-root https://...")
    return mirror
