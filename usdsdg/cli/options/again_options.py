"""The options of commands that make frames of a dataset again."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import click

from usdsdg.cli.options.map_option import map_option
from usdsdg.cli.options.values import PATH


class How(NamedTuple):
    """What the recipe does not tell, or tells of another machine: where the script, its stage and its assets are."""

    source: Path | None = None
    stage: Path | None = None
    maps: tuple[str, ...] = ()


def again_options(command: Callable[..., None]) -> Callable[..., None]:
    """Decorate a command with these options, which it gets as `how`."""

    @click.option("--source", type=PATH, help="The script or configuration.", show_default="the copy beside the data")
    @click.option("--stage", type=PATH, help="The stage that --stage of the run named.")
    @map_option
    @functools.wraps(command)
    def gathered(*, source: Path | None, stage: Path | None, map_: tuple[str, ...], **others: Any) -> None:
        command(how=How(source, stage, map_), **others)

    return gathered
