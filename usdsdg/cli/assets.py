"""`usdsdg assets get | list | check`: the copy of an assets root that is a URL, and of single assets."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import AssetsRoot, Quiet, command_context
from usdsdg.errors import ConfigError

if TYPE_CHECKING:
    from usdsdg.mirror.root_mirror import RootMirror

app = typer.Typer(help="Copy assets of a root that is a URL to this machine, and check the copy.", no_args_is_help=True)


@app.command(epilog=epilog("assets get"))
def get(
    urls: Annotated[list[str], typer.Argument(metavar="URL...", help="Files, as /Isaac/Props/cup.usd, or URLs.")],
    assets_root: AssetsRoot = None,
    quiet: Quiet = False,
) -> None:
    """Copy files with all that they refer to: layers, payloads, textures and materials."""
    with command_context(assets_root=assets_root, quiet=quiet):
        from usdsdg.stage import assets

        if not all(map(assets.is_remote, urls)):
            _mirror()
        for url in urls:
            print(assets.locate(url))


@app.command(name="list", epilog=epilog("assets list"))
def list_(assets_root: AssetsRoot = None) -> None:
    """Print each file that has been copied, with its size and the beginning of its SHA-256."""
    with command_context(assets_root=assets_root, quiet=True):
        mirror = _mirror()
        records = mirror.records()
        for record in records:
            print(f"{record.sha256[:12]} {record.size:>12,} {record.path}")
        size = sum(record.size for record in records)
        print(f"{len(records)} files of {mirror.url}, {size / 1e6:,.1f} MB, in {mirror.folder}")


@app.command(epilog=epilog("assets check"))
def check(
    assets_root: AssetsRoot = None,
    repair: Annotated[bool, typer.Option("--repair", help="Copy damaged files again.")] = False,
    quiet: Quiet = False,
) -> None:
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
        print(f"{count} files, {len(damaged)} damaged{' and copied again' if repair and damaged else ''}")
        if damaged and not repair:
            raise typer.Exit(1)


def _mirror() -> RootMirror:
    """Return the mirror of the configured root.

    Raises:
        ConfigError: the root is a folder, or none is set.
    """
    from usdsdg.mirror.root_mirror import RootMirror
    from usdsdg.stage import assets

    mirror = assets.root_mirror()
    if not isinstance(mirror, RootMirror):
        root = assets.configured_root()
        where = f"{root} is a folder" if root else "none is set"
        raise ConfigError(f"the assets root is no URL ({where}), so nothing is copied. Give --assets-root https://...")
    return mirror
