"""The commands `usdsdg run | generate | render | simulate | view | inspect | verify | merge | convert | compat | new |
schema | assets | warmup | doctor | completion`.

They are light to import.
"""

import atexit
import gc
import sys

import click

from usdsdg.cli.assets import assets
from usdsdg.cli.command import Group
from usdsdg.cli.compat import compat
from usdsdg.cli.completion import completion
from usdsdg.cli.convert import convert
from usdsdg.cli.doctor import doctor
from usdsdg.cli.generate import generate
from usdsdg.cli.inspect import inspect
from usdsdg.cli.merge import merge
from usdsdg.cli.new import new
from usdsdg.cli.options.optional_values import completed
from usdsdg.cli.render import render
from usdsdg.cli.reproduce import reproduce
from usdsdg.cli.run import run
from usdsdg.cli.schema import schema
from usdsdg.cli.simulate import simulate
from usdsdg.cli.verify import verify
from usdsdg.cli.view import view
from usdsdg.cli.warmup import warmup

# Columns: help takes the width of the terminal, which click bounds by 80.
WIDEST = 1000


def _print_version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        import usdsdg

        print(f"usdsdg {usdsdg.__version__}")
        context.exit()


@click.group("usdsdg", cls=Group, context_settings={"max_content_width": WIDEST})
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
    run, generate, render, simulate, view, inspect, verify, reproduce, merge, convert, compat, new, schema, assets,
    warmup, doctor, completion,
):  # fmt: skip
    app.add_command(command)


def main() -> None:
    """Run the command of the command line."""
    # Without this the garbage collector walks all modules at exit, which takes seconds once newton is loaded.
    atexit.register(gc.freeze)
    app(completed(sys.argv[1:]))
