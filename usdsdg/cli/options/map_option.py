"""The option that says where the assets of another machine are on this one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

map_option = click.option(
    "--map",
    "map_",
    multiple=True,
    metavar="PREFIX=FOLDER",
    help="Where the assets below a URL or path of another machine are; repeatable, also in usdsdg.toml.",
)


def use_maps(given: Sequence[str], source: Path) -> None:
    """Let maps count from now on: those given, and those of the configuration files for a script, job or stage.

    Raises:
        ConfigError: a map, or a file of maps, is wrong.
    """
    from usdsdg.cli.script.config_file import maps_of_files
    from usdsdg.stage import assets

    maps = [assets.PathMap.parse(text) for text in given]
    assets.set_maps([*maps, *maps_of_files(source, taken={each.prefix for each in maps})])


def with_whole_paths(given: Sequence[str]) -> list[str]:
    """Return maps as they are in processes that work in other folders.

    Raises:
        ConfigError: a map is wrong.
    """
    from usdsdg.stage.assets import PathMap

    return ["=".join(PathMap.parse(text)) for text in given]
