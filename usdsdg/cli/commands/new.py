"""`usdsdg new KIND [PATH]`: write a starting point that runs as it is."""

import enum
import shlex
from importlib import resources
from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context
from usdsdg.cli.options.values import PATH, Member

SCHEMA = "usdsdg.schema.json"


class Kind(enum.StrEnum):
    """What can be started from."""

    DETECTION = "detection"
    BIN_PICKING = "bin-picking"
    SCRIPT = "script"


_FILES = {
    Kind.DETECTION: "detection.yaml",
    Kind.BIN_PICKING: "bin_picking.yaml",
    Kind.SCRIPT: "script.py",
}
_TEMPLATES = _FILES | {Kind.SCRIPT: "script.py.in"}  # no module that an import would run


@click.command(cls=Command, epilog=epilog("new"))
@argument("kind", type=Member(Kind), help="A job for a detector, one of parts in a bin, or a script.")
@argument(
    "path",
    type=PATH,
    required=False,
    help="The file to write.",
    default_text="detection.yaml, bin_picking.yaml or script.py",
)
def new(kind: Kind, path: Path | None) -> None:
    """Write a commented starting point, which runs as it is.

    Configurations name the schema that is written beside them, so that editors complete their keys.
    """
    with command_context(quiet=True):
        for line in write_starting_point(kind, path or Path(_FILES[kind])):
            print(line)


def write_starting_point(kind: Kind, path: Path) -> list[str]:
    """Write the file, and the schema beside a configuration; return what to say of it.

    Raises:
        OutputNotWritable: the file exists, has a suffix of another kind, or cannot be written.
    """
    from usdsdg.cli.commands.schema import schema_text
    from usdsdg.errors import OutputNotWritable
    from usdsdg.stores.whole_file import write_new, write_whole

    template = resources.files("usdsdg.cli") / "starting_points" / _TEMPLATES[kind]
    suffixes = {".py"} if kind is Kind.SCRIPT else {".yaml", ".yml"}
    if path.suffix.lower() not in suffixes:
        raise OutputNotWritable(f"{path}: a {kind} is a {' or '.join(sorted(suffixes))} file; name it so")
    in_the_way = OutputNotWritable(f"{path} exists and is not replaced; give another PATH, or remove it")
    if path.exists():
        raise in_the_way
    try:
        # The starting point last: where that or the schema cannot be written, the same command can be given again.
        if kind is not Kind.SCRIPT:
            write_whole(path.absolute().parent / SCHEMA, schema_text().encode())
        is_new = write_new(path.absolute(), template.read_bytes())
    except OutputNotWritable as error:
        raise OutputNotWritable(f"{path} cannot be written: {error.cause}; give another PATH") from error
    if not is_new:
        raise in_the_way
    command = "run" if kind is Kind.SCRIPT else "generate"
    return [str(path), f"next: usdsdg {command} {shlex.quote(str(path))}"]
