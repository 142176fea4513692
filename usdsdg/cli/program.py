"""Entry point of the `usdsdg` program: what stands before the first heavy import."""

from usdsdg.cli.closed_streams import let_stderr_fail, replace_closed_streams
from usdsdg.cli.interrupts import end_at_once_on_interrupt, forget_interrupts


def main() -> None:
    """Run the `usdsdg` program."""
    replace_closed_streams()
    let_stderr_fail()
    end_at_once_on_interrupt()
    from usdsdg.cli.app import main as run_command

    try:
        run_command()
    finally:
        forget_interrupts()
