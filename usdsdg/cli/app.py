"""The commands `usdsdg run | generate | render | simulate | view | inspect | verify | repair | reproduce | merge |
convert | compat | new | schema | assets | warmup | doctor | completion`.

They are light to import.
"""

import atexit
import gc
import sys

import click

from usdsdg.cli.command import Group
from usdsdg.cli.commands.assets import assets
from usdsdg.cli.commands.compat import compat
from usdsdg.cli.commands.completion import completion
from usdsdg.cli.commands.convert import convert
from usdsdg.cli.commands.doctor import doctor
from usdsdg.cli.commands.generate import generate
from usdsdg.cli.commands.inspect import inspect
from usdsdg.cli.commands.merge import merge
from usdsdg.cli.commands.new import new
from usdsdg.cli.commands.render import render
from usdsdg.cli.commands.repair import repair
from usdsdg.cli.commands.reproduce import reproduce
from usdsdg.cli.commands.run import run
from usdsdg.cli.commands.schema import schema
from usdsdg.cli.commands.simulate import simulate
from usdsdg.cli.commands.verify import verify
from usdsdg.cli.commands.view import view
from usdsdg.cli.commands.warmup import warmup
from usdsdg.cli.options.file_kinds import command_of
from usdsdg.cli.options.optional_values import completed
from usdsdg.cli.output import printing

# Columns: help takes the width of the terminal, which click bounds by 80.
WIDEST = 1000


def _print_version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        import usdsdg

        print(f"usdsdg {usdsdg.__version__}")
        context.exit()


@click.group("usdsdg", cls=Group, meant=command_of, context_settings={"max_content_width": WIDEST})
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Print the version and exit.",
)
def app() -> None:
    """Synthetic data from USD scenes: the Replicator API on open-source components."""


for command in (
    run, generate, render, simulate, view, inspect, verify, repair, reproduce, merge, convert, compat, new, schema,
    assets, warmup, doctor, completion,
):  # fmt: skip
    app.add_command(command)


def main() -> None:
    """Run the command of the command line."""
    # Without this the garbage collector walks all modules at exit, which takes seconds once newton is loaded.
    atexit.register(gc.freeze)
    with printing():
        app(completed(sys.argv[1:]))
