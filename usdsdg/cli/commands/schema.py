"""`usdsdg schema [KIND]`: the JSON schema of configurations, for editors."""

import enum
import json

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context
from usdsdg.cli.options.values import Member


class SchemaKind(enum.StrEnum):
    """A job that has configurations."""

    OBJECT_BASED = "object-based"
    DETECTION = "detection"
    BIN_PICKING = "bin-picking"


@click.command(cls=Command, epilog=epilog("schema"))
@argument(
    "kind",
    type=Member(SchemaKind),
    required=False,
    metavar="[KIND]",
    help="object-based, detection or bin-picking.",
    default_text="all, chosen by the key job",
)
def schema(kind: SchemaKind | None) -> None:
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
