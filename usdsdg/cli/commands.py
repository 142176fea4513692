"""The commands `usdsdg run | generate | render | simulate | view | inspect | verify | merge | convert | compat | new |
schema | assets | warmup | doctor`.

They are light to import.
"""

import atexit
import gc
import sys
from typing import Annotated

import typer

from usdsdg.cli import assets
from usdsdg.cli.compat import compat
from usdsdg.cli.convert import convert
from usdsdg.cli.doctor import doctor
from usdsdg.cli.examples import epilog
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

app = typer.Typer(
    name="usdsdg", help="Synthetic data from USD scenes: the Replicator API on open-source components.",
    no_args_is_help=True, pretty_exceptions_enable=False,
)  # fmt: skip
# Options after the script's name belong to the script.
app.command(context_settings={"allow_interspersed_args": False}, epilog=epilog("run"))(run)
for command in (
    generate, render, simulate, view, inspect, verify, reproduce, merge, convert, compat, new, schema, warmup, doctor,
):  # fmt: skip
    app.command(epilog=epilog(command.__name__))(command)
app.add_typer(assets.app, name="assets")


def _print_version(wanted: bool) -> None:
    if wanted:
        import usdsdg

        print(f"usdsdg {usdsdg.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None: ...


def main() -> None:
    """Run the command of the command line."""
    # Without this the garbage collector walks all modules at exit, which takes seconds once newton is loaded.
    atexit.register(gc.freeze)
    app(completed(sys.argv[1:]))
