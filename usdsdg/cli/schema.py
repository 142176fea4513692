"""`usdsdg schema [KIND]`: the JSON schema of configurations, for editors."""

import enum
import json
from typing import Annotated

import typer

from usdsdg.cli.options.command_context import command_context


class SchemaKind(enum.StrEnum):
    """A job that has configurations."""

    OBJECT_BASED = "object-based"
    DETECTION = "detection"
    BIN_PICKING = "bin-picking"


def schema(
    kind: Annotated[
        SchemaKind | None,
        typer.Argument(
            metavar="[KIND]", help="object-based, detection or bin-picking.", show_default="all, chosen by the key job"
        ),
    ] = None,
) -> None:
    """Print the JSON schema of configurations: keys with what they mean, types and bounds.

    An editor that knows YAML completes keys and underlines mistakes where the first line of a configuration is
    `# yaml-language-server: $schema=FILE`, as in the files that `usdsdg new` makes.
    """  # fmt: skip
    with command_context(quiet=True):
        print(schema_text(kind))


def schema_text(kind: SchemaKind | None = None) -> str:
    """Return the schema as JSON."""
    from usdsdg.scenarios.config_schema import config_schema

    return json.dumps(config_schema(kind.value.replace("-", "_") if kind else None), indent=1, ensure_ascii=False)
