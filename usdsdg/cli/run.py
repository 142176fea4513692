"""`usdsdg run SCRIPT`: an existing Replicator or Isaac Sim script, unchanged."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.session import AssetsRoot, Device, Quiet, SaveStage, Seed, seed_everything, session


def run(
    context: typer.Context,
    script: Annotated[Path, typer.Argument(help="The script, standalone or from the Script Editor.")],
    assets_root: AssetsRoot = None,
    device: Device = None,
    seed: Seed = 0,
    save_stage: SaveStage = None,
    quiet: Quiet = False,
) -> None:
    """Run an existing Replicator or Isaac Sim script unchanged; it ends when its tasks have ended."""
    if not script.is_file():
        print(f"error: no script {script}", file=sys.stderr)
        raise typer.Exit(1)
    with session(assets_root=assets_root, device=device, quiet=quiet, save_stage=save_stage):
        seed_everything(seed)
        execute(script, context.args)


def execute(script: Path, arguments: list[str]) -> None:
    """Run the script's file as `__main__` inside the event loop, then its tasks to their end.

    Raises:
        typer.Exit: the script failed; its traceback, from the script on, has been printed.
    """
    from usdsdg import compat
    from usdsdg.app import get_app
    from usdsdg.errors import UsdsdgError
    from usdsdg.stage.context import current_stage

    compat.install()
    sys.argv = [str(script), *arguments]
    sys.path.insert(0, str(script.resolve().parent))
    namespace = {"__name__": "__main__", "__file__": str(script), "__builtins__": __builtins__}
    current_stage()
    try:
        code = compile(script.read_text(encoding="utf-8"), str(script), "exec")
        get_app().run(lambda: exec(code, namespace))
    except SystemExit as ended:
        if ended.code not in (None, 0):
            raise typer.Exit(ended.code if isinstance(ended.code, int) else 1) from None
    except (UsdsdgError, KeyboardInterrupt) as error:
        _say_where(error, script)
        raise
    except Exception as error:  # noqa: BLE001 - whatever the script raised is the script's to show
        _print_from(error, script)
        raise typer.Exit(1) from None


def _frames(error: BaseException, script: Path) -> list[traceback.FrameSummary]:
    """The traceback from the script's first line on."""
    frames = traceback.extract_tb(error.__traceback__)
    first = next((i for i, frame in enumerate(frames) if frame.filename == str(script)), 0)
    return list(frames[first:])


def _say_where(error: BaseException, script: Path) -> None:
    lines = [frame for frame in _frames(error, script) if frame.filename == str(script)]
    if lines:
        print(f"{script}:{lines[-1].lineno}: in {lines[-1].name}", file=sys.stderr)


def _print_from(error: BaseException, script: Path) -> None:
    print("Traceback (most recent call last):", file=sys.stderr)
    print("".join(traceback.format_list(_frames(error, script))), end="", file=sys.stderr)
    print("".join(traceback.format_exception_only(error)), end="", file=sys.stderr)
