"""What all commands share: common options, setup, progress, errors and interruption."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click
from click.exceptions import Exit

from usdsdg.cli.interrupts import INTERRUPTED, let_commands_be_interrupted
from usdsdg.cli.options.class_file import class_file
from usdsdg.cli.options.output_path import output_path
from usdsdg.cli.options.thread_limit import limit_threads
from usdsdg.cli.options.values import PATH, PLACE, WholeRange
from usdsdg.cli.out_of_reach import out_of_reach
from usdsdg.errors import ConfigError, UsdsdgError, UsdsdgWarning, counted
from usdsdg.operating_system import interrupt_main_thread
from usdsdg.session import progress
from usdsdg.session.devices.memory import device_memory
from usdsdg.session.endings import failures, parent_process, termination
from usdsdg.session.endings.failures import tell

if TYPE_CHECKING:
    from pxr import Sdf

REPEAT_SECONDS = 0.02
DROP_SECONDS = 2.0
_is_ending = threading.Event()  # after an interrupt, all files of which are finished
COMPILER_THREADS = "usdsdg-compile"  # prefix of the names of threads in which both engines compile kernels

assets_root_option = click.option(
    "--assets-root",
    help="Folder with the assets, laid out like Isaac Sim's, or its http(s) URL.",
    type=PLACE,
    show_default="USDSDG_ASSETS_ROOT, else demo assets",
)
device_option = click.option(
    "--device", help="Where pictures are made: cpu or cuda:0.", show_default="CUDA where there is one"
)
physics_device_option = click.option(
    "--physics-device",
    help="Where bodies are simulated: cpu, or cuda:0 for a thousand bodies and more.",
    default="cpu",
    show_default=True,
)
seed_option = click.option(
    "--seed",
    type=WholeRange(min=0),
    default=0,
    help="Seed of the run; the same seed writes the same bytes.",
    show_default=True,
)
semantic_classes_option = click.option(
    "--semantic-classes",
    type=PLACE,
    metavar="TEXT",
    help="Classes of the dataset: names separated by commas, a .json, .yaml or .txt file, or the folder of a "
    "dataset that goes on.",
    show_default="what stage and graph can show",
)
save_stage_option = click.option(
    "--save-stage", type=PATH, help="Save the stage of the last captured frame as .usd, .usda or .usdc."
)
quiet_option = click.option("--quiet", "-q", is_flag=True, help="Print no progress.")


_MAY_GO_ON = ("generate", "run")  # the commands with --resume


@contextmanager
def command_context(
    *,
    assets_root: str | None = None,
    device: str | None = None,
    physics_device: str | None = None,
    threads: int | None = None,
    quiet: bool = False,
    save_stage: Path | None = None,
    keeps_files: bool = True,
) -> Iterator[None]:
    """Set up, run the body of a command, and finish its files.

    keeps_files: False for a command that makes no dataset or other result bit by bit, where it is ended early.

    Errors of usdsdg, Ctrl-C and signals to end (SIGTERM, SIGHUP, SIGXCPU) end the program with one message, without a
    traceback.
    """
    warnings.showwarning = _plain_warning
    sys.unraisablehook = _repeat_lost_interrupt
    progress.use_default(quiet)
    failures.begin()
    _is_ending.clear()
    limit_threads(threads)
    with termination.listening():
        try:
            # While Ctrl-C still ends the process at once: extension modules drop a KeyboardInterrupt that is raised
            # while they are imported.
            import usdsdg.orchestrator  # noqa: F401

            let_commands_be_interrupted()
            parent_process.watch()
            snapshot = _set_up(assets_root, device, physics_device, save_stage)
            with device_memory():
                yield
            with _last_frames():
                finish_files()
                _close_run(complete=True)
            if snapshot is not None:
                snapshot.write()
        except UsdsdgError as error:
            _exit_with_error(error)
        except Exit as ended:
            if ended.exit_code:
                _finish_after_failure(ended.exit_code, reached_end=isinstance(ended, ReachedEnd))
            raise
        except KeyboardInterrupt as interrupt:
            _exit_interrupted(interrupt, keeps_files)
        except Exception as error:
            if (known := as_usdsdg_error(error)) is None:
                raise
            _exit_with_error(known)
        finally:
            progress.use(progress.SilentReporter())


@contextmanager
def _last_frames() -> Iterator[None]:
    """Let threads that a script has left behind end the frame that they capture, and give them no more of them."""
    from usdsdg.session.session import current
    from usdsdg.session.turns import LAST_FRAME_SECONDS, turns

    current().run.is_at_exit = True
    with turns.within(LAST_FRAME_SECONDS):
        yield


def as_usdsdg_error(error: Exception) -> UsdsdgError | None:
    """Return an error to print without a traceback: usdsdg's own, or one that names the stage for pxr's; else None.

    Also where the working folder is gone, which any relative path comes upon, or a file or folder is out of reach.
    """
    if isinstance(error, UsdsdgError):
        return error
    if isinstance(error, FileNotFoundError) and not _has_working_folder():
        return ConfigError("the working folder of this shell was removed; change to one that is there (cd)")
    return _unreadable(error) if _is_of_pxr(error) else out_of_reach(error)


def _has_working_folder() -> bool:
    try:
        os.getcwd()
    except FileNotFoundError:
        return False
    return True


def _is_of_pxr(error: Exception) -> bool:
    """Return whether an error is pxr's own, without importing that for the question."""
    module = sys.modules.get("pxr.Tf")
    return module is not None and isinstance(error, module.ErrorException)


def _set_up(
    assets_root: str | None, device: str | None, physics_device: str | None, save_stage: Path | None
) -> _StageSnapshot | None:
    """Apply the common options; options that cannot work are errors before any work is done."""
    from usdsdg.session import devices
    from usdsdg.stage import assets
    from usdsdg.stage.assets import url

    snapshot = _StageSnapshot(save_stage) if save_stage is not None else None
    if assets_root is not None:
        if not url.scheme_of(assets_root) and not os.path.isdir(os.path.expanduser(assets_root)):
            raise ConfigError(f"--assets-root {assets_root!r} is no folder; give one, or the URL of a server or bucket")
        assets.set_assets_root(assets_root)
    devices.use_device(device, physics=physics_device)
    return snapshot


def _exit_with_error(error: UsdsdgError) -> NoReturn:
    progress.use(progress.SilentReporter())
    tell(error)
    _finish_after_failure(1)
    raise Exit(1) from None


def _unreadable(error: Exception) -> UsdsdgError:
    """Return an error of pxr, which a damaged value may raise wherever it is read, as one that names the stage."""
    from usdsdg.errors import AssetUnreadable
    from usdsdg.session.session import current
    from usdsdg.stage.usd_errors import reason

    stage = current().stage
    name = stage.GetRootLayer().realPath if stage is not None else ""
    what = " ".join(reason(error).split())  # type: ignore[arg-type] - it is a Tf.ErrorException
    return AssetUnreadable(
        f"{name or 'the stage'} has a value that USD cannot read: {what}. Mend it, or export it again."
    )


class ReachedEnd(Exit):
    """A command has an exit code for its failure, but all of its frames: its run has come to its end."""


def _finish_after_failure(code: int, *, reached_end: bool = False) -> bool:
    """End the run for its writers, which may have files to close; print what fails, and return whether nothing did.

    code: the exit code, if Ctrl-C or a signal comes again. reached_end: all frames of the run are there.
    """
    from usdsdg.session.session import current
    from usdsdg.session.turns import turns

    progress.use(progress.SilentReporter())
    if current().run.is_copy:  # the files are those of the process that a script has forked
        return True
    current().run.ends_early = not reached_end
    is_whole = False
    try:
        with turns:  # after the frame of another thread, which gets no more of them
            try:
                finish_files()
                is_whole = reached_end
            finally:
                _close_run(complete=is_whole)
        return True
    except UsdsdgError as error:
        tell(error, "at the end of the run: ")
    except Exception as error:  # noqa: BLE001 - a script's own writer may raise anything at its end
        print(f"error: at the end of the run: {type(error).__name__}: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        _drop_files()
        sys.stderr.flush()
        os._exit(code)
    return False


def _exit_interrupted(interrupt: KeyboardInterrupt, keeps_files: bool) -> NoReturn:
    progress.use(progress.SilentReporter())
    is_signal = isinstance(interrupt, termination.Terminated)
    code, what = (interrupt.exit_code, str(interrupt)) if is_signal else (INTERRUPTED, "interrupted")
    _tell(f"{what}: finishing the files in hand; Ctrl-C again stops at once" if keeps_files else what)
    if _finish_after_failure(code) and keeps_files:
        _tell(f"files written so far are whole{_how_to_go_on()}")
    _is_ending.set()
    if any(thread.name.startswith(COMPILER_THREADS) for thread in threading.enumerate()):
        _exit_without_joining_compilers(code)
    raise Exit(code) from None


def _how_to_go_on() -> str:
    """Return "; ..." with what goes on with the frames that a command was making; "" where nothing does."""
    from usdsdg.session.session import current
    from usdsdg.writers.journal.earlier_run import Mode

    run = current().run
    if not run.folders or run.scratch is not None or run.recipe is None or run.recipe.command not in _MAY_GO_ON:
        return ""
    return f"; the same command with --resume{' in place of --overwrite' if run.mode is Mode.OVERWRITE else ''} goes on"


def _tell(line: str) -> None:
    """Print to stderr, where anyone reads it: a terminal that hung up is gone."""
    with suppress(OSError):
        print(line, file=sys.stderr, flush=True)


def _drop_files() -> None:
    """Leave out the files that wait to be written, so that none is cut off: a file in hand gets a moment to end."""
    from usdsdg.session.session import current

    with suppress(KeyboardInterrupt):
        dropped = current().io_queue.stop(seconds=DROP_SECONDS)
        print(f"stopped: {counted(dropped, 'file was', 'files were')} not written", file=sys.stderr)


def _exit_without_joining_compilers(code: int) -> NoReturn:
    """End the program without waiting for threads that compile kernels, which cannot be interrupted."""
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def seed_everything(seed: int) -> None:
    """Seed usdsdg's draws and the generators that scripts use: Python's `random` and NumPy's legacy generator."""
    import random

    import numpy as np

    from usdsdg.graph.sampling import set_global_seed

    set_global_seed(seed)
    random.seed(seed)
    np.random.seed(seed & 0xFFFFFFFF)


def fix_classes(given: Any) -> None:
    """Fix the classes of the dataset, if the user has given any: by the option's text, or as `semantic_classes`."""
    if given is None:
        return
    from usdsdg.settings import set_semantic_classes
    from usdsdg.stage.semantics.semantic_classes import read_class_file

    if isinstance(given, str):
        file = class_file(given)
        # The content, not the path: the recipe keeps this setting, and the file may change or go.
        given = read_class_file(file) if file else [name.strip() for name in given.split(",")]
    set_semantic_classes(given)


def finish_files() -> None:
    """Wait until every file has been written; raises the failure of a writer or its backend."""
    from usdsdg import orchestrator

    orchestrator.wait_until_complete()


def _close_run(*, complete: bool) -> None:
    """Close the journals of the dataset, where the command has made one."""
    from usdsdg.session.session import current
    from usdsdg.writers.aggregates import finish_run

    if current().run.folders:
        finish_run(complete=complete)


def _plain_warning(message: object, category: type, filename: str, lineno: int, *_: object) -> None:
    if issubclass(category, UsdsdgWarning):
        print(f"warning: {message}", file=sys.stderr)
    else:
        print(f"{filename}:{lineno}: {category.__name__}: {message}", file=sys.stderr)


def _repeat_lost_interrupt(
    unraisable: sys.UnraisableHookArgs,
    pythons_hook: Callable[[sys.UnraisableHookArgs], object] = sys.__unraisablehook__,
) -> None:
    """Raise a Ctrl-C or signal to end again shortly after Python has dropped it, which it does inside a `__del__`.

    `pythons_hook`: an argument, since Python clears its modules, this one and `sys`, before the last `__del__` runs.
    """
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        pythons_hook(unraisable)
        return
    number = getattr(unraisable.exc_value, "number", signal.SIGINT)
    timer = threading.Timer(REPEAT_SECONDS, _interrupt_again, (number,))
    timer.daemon = True
    timer.start()


def _interrupt_again(number: int) -> None:
    """Raise a lost interrupt, unless another one has ended the command: Python would die of it at its end."""
    if not _is_ending.is_set():
        interrupt_main_thread(number)


class _StageSnapshot:
    """Copy of the stage at the last capture; scripts stop the timeline afterward, which restores the first poses."""

    def __init__(self, path: Path) -> None:
        from usdsdg.orchestrator import get_orchestrator
        from usdsdg.stage import flatten

        self._path = output_path(path).absolute()
        flatten.check_writable(self._path)
        self._layer: Sdf.Layer | None = None
        get_orchestrator().on_captured(self._take)

    def _take(self) -> None:
        from usdsdg.session.stage_context import snapshot

        self._layer = snapshot(self._path.parent)

    def write(self) -> None:
        """Save the copy, or the current stage where nothing was captured."""
        from usdsdg.stage import flatten

        if self._layer is None:
            self._take()
        flatten.write_layer(self._layer, self._path)
        print(f"stage of the last frame: {self._path}")
