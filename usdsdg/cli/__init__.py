"""The command line: `usdsdg run | generate | render | simulate | inspect | doctor`; imports stay inside commands."""

from __future__ import annotations

import typer

from usdsdg.cli.doctor import doctor
from usdsdg.cli.generate import generate
from usdsdg.cli.inspect_page import inspect
from usdsdg.cli.render import render
from usdsdg.cli.run import run
from usdsdg.cli.simulate import simulate

app = typer.Typer(
    name="usdsdg", help="Synthetic data from USD scenes: the Replicator API on open parts.", no_args_is_help=True,
    pretty_exceptions_enable=False, add_completion=False,
)  # fmt: skip
# A script's own options belong to the script.
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(run)
for command in (generate, render, simulate, inspect, doctor):
    app.command()(command)


def main() -> None:
    """Entry point of the `usdsdg` program."""
    app()
