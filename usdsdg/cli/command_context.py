"""What all commands share: options, set-up, progress, and how an error ends the program."""

from __future__ import annotations

import _thread
import atexit
import os
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from usdsdg.cli.program import INTERRUPTED, let_commands_be_interrupted
from usdsdg.errors import UsdsdgError, UsdsdgWarning
from usdsdg.session import progress

REPEAT_SECONDS = 0.02
COMPILERS = "usdsdg-compile"  # how the names of both engines' compiling threads begin

AssetsRoot = Annotated[
    Path | None,
    typer.Option(
        help="Folder with the assets, laid out like Isaac Sim's.",
        show_default="USDSDG_ASSETS_ROOT, else demo assets",
    ),
]
Device = Annotated[str | None, typer.Option(help="cpu or cuda:0.", show_default="CUDA where there is one")]
Seed = Annotated[int, typer.Option(min=0, help="The one seed of the run; the same seed leaves the same bytes.")]
SaveStage = Annotated[
    Path | None, typer.Option(help="Write the stage of the last captured frame as .usd, .usda or .usdc.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")]


@contextmanager
def command_context(
    *, assets_root: Path | None = None, device: str | None = None, quiet: bool = False, save_stage: Path | None = None
) -> Iterator[None]:
    """Set up, run the body, finish its files; errors of ours and Ctrl-C end the program with one plain message."""
    warnings.showwarning = _plain_warning
    sys.unraisablehook = _interrupt_again
    progress.use_default(quiet)
    try:
        let_commands_be_interrupted()
        keeper = _set_up(assets_root, device, save_stage)
        yield
        _finish_files()
        if keeper is not None:
            keeper.write()
    except UsdsdgError as error:
        _fail(error)
    except KeyboardInterrupt:
        _end_interrupted()
    finally:
        progress.use(progress.Silent())


def _set_up(assets_root: Path | None, device: str | None, save_stage: Path | None) -> _StageKeeper | None:
    """Take the options over; what cannot work is refused before any work."""
    from usdsdg.session import engines
    from usdsdg.stage import assets

    keeper = _StageKeeper(save_stage) if save_stage is not None else None
    if assets_root is not None:
        assets.set_assets_root(assets_root)
    engines.use_device(device)
    return keeper


def _fail(error: UsdsdgError) -> NoReturn:
    progress.use(progress.Silent())
    print(f"error: {error}", file=sys.stderr)
    raise typer.Exit(1) from None


def _end_interrupted() -> NoReturn:
    progress.use(progress.Silent())
    print("interrupted: finishing the files in hand; Ctrl-C again stops at once", file=sys.stderr)
    try:
        _finish_files()
        print("files written so far are whole", file=sys.stderr)
    except UsdsdgError as error:
        print(f"error: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        # Files appear whole or not at all, so that nothing has to be waited for.
        sys.stderr.flush()
        os._exit(INTERRUPTED)
    if any(thread.name.startswith(COMPILERS) for thread in threading.enumerate()):
        _leave_compilers()
    raise typer.Exit(INTERRUPTED) from None


def _leave_compilers() -> NoReturn:
    """End the program without waiting for threads that compile kernels, which nothing can interrupt."""
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(INTERRUPTED)


def seed_everything(seed: int) -> None:
    """One seed for usdsdg's draws and for what scripts use: Python's `random` and NumPy's legacy generator."""
    import random

    import numpy as np

    from usdsdg.graph.sampling import set_global_seed

    set_global_seed(seed)
    random.seed(seed)
    np.random.seed(seed & 0xFFFFFFFF)


def _finish_files() -> None:
    from usdsdg import orchestrator

    orchestrator.wait_until_complete()


def _plain_warning(message: Any, category: type, filename: str, lineno: int, *_: Any) -> None:
    if issubclass(category, UsdsdgWarning):
        print(f"warning: {message}", file=sys.stderr)
    else:
        print(f"{filename}:{lineno}: {category.__name__}: {message}", file=sys.stderr)


def _interrupt_again(dropped: sys.UnraisableHookArgs) -> None:
    """Python drops a Ctrl-C that comes while it runs a `__del__`; let it come again a moment later."""
    if dropped.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(dropped)
        return
    timer = threading.Timer(REPEAT_SECONDS, _thread.interrupt_main)
    timer.daemon = True
    timer.start()


class _StageKeeper:
    """Remembers the stage as it was at the last capture, since scripts stop the timeline, which moves all back."""

    def __init__(self, path: Path) -> None:
        from usdsdg.orchestrator import get_orchestrator
        from usdsdg.stage import flatten

        self._path = path.absolute()
        flatten.check_place(self._path)
        self._layer: Any = None
        get_orchestrator().on_captured(self._remember)

    def _remember(self) -> None:
        from usdsdg.session.stage_context import snapshot

        self._layer = snapshot(self._path.parent)

    def write(self) -> None:
        from usdsdg.stage import flatten

        if self._layer is None:
            self._remember()
        flatten.write_layer(self._layer, self._path)
        print(f"stage of the last frame: {self._path}")
