"""Kinds of values that options and arguments have."""

import enum
import math
from pathlib import Path
from typing import Any

import click

# A path on this machine.
PATH = click.Path(path_type=Path)
# A folder or a URL, as text.
PLACE = click.Path(readable=False)


class Member(click.Choice):
    """One of the values of an enumeration."""

    def __init__(self, kind: type[enum.StrEnum]) -> None:
        super().__init__([each.value for each in kind])
        self._kind = kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and value not in self.choices:
            value = value.replace("_", "-")  # as the job of `bin-picking` is called in configurations
        return self._kind(super().convert(value, param, ctx))


class WholeRange(click.IntRange):
    """A whole number between bounds, which click calls an integer range in its errors."""

    name = "whole number"


class NumberRange(click.FloatRange):
    """A number between bounds. `nan`, which click takes, is neither above nor below one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not a number.", param, ctx)
        return number
