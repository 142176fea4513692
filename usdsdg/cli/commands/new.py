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

    template = resources.files("usdsdg.cli") / "starting_points" / _TEMPLATES[kind]
    suffixes = {".py"} if kind is Kind.SCRIPT else {".yaml", ".yml"}
    if path.suffix.lower() not in suffixes:
        raise OutputNotWritable(f"{path}: a {kind} is a {' or '.join(sorted(suffixes))} file; name it so")
    if path.exists():
        raise OutputNotWritable(f"{path} exists and is not replaced; give another PATH, or remove it")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(template.read_text(encoding="utf-8"))
        if kind is not Kind.SCRIPT:
            (path.parent / SCHEMA).write_text(schema_text(), encoding="utf-8")
    except OSError as error:
        raise OutputNotWritable(f"{path} cannot be written: {error.strerror or error}; give another PATH") from error
    command = "run" if kind is Kind.SCRIPT else "generate"
    return [str(path), f"next: usdsdg {command} {shlex.quote(str(path))}"]
