"""Execution of a script's file as `__main__`, and what is printed where it fails."""

from __future__ import annotations

import ast
import asyncio
import importlib
import inspect
import linecache
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, ModuleType, TracebackType
from typing import Any

from click.exceptions import Exit

from usdsdg.cli.script.data_files import data_files
from usdsdg.cli.script.packed_colors import reads_packed_colors
from usdsdg.errors import ScriptStopped, UsdsdgError


class ScriptEnded(Exit):
    """A script has ended with an exit code of its own; `why` is the last line of what it printed of its failure."""

    def __init__(self, code: int, why: str = "") -> None:
        super().__init__(code)
        self.why = why


def execute(script: Path, arguments: list[str], *, frames: int | None = None) -> None:
    """Run the script's file as `__main__`, then its asyncio tasks until they end.

    frames: capture frames 0 to this one in a run that nothing ends, or after the script if it captures nothing.

    Raises:
        ScriptEnded: the script failed or called sys.exit; its traceback, from the script on, has been printed.
        MissingAssets: it names assets that are missing.
    """
    from usdsdg import compat
    from usdsdg.app.app import get_app
    from usdsdg.compat import children, kit_arguments
    from usdsdg.session.session import current
    from usdsdg.session.stage_context import current_stage

    compat.install()
    children.reach()
    sys.argv = [str(script), *arguments]
    kit_arguments.apply(arguments)
    if frames is not None:
        current().orchestrator.frames_without_end = frames + 1
    sys.path.insert(0, str(script.resolve().parent))
    main = _main_module(script)
    current_stage()
    data_files.watch(script)
    with exit_of(script):
        program = _program(script, main.__dict__)
        tasks: list[asyncio.Task[Any]] = []  # the event loop does not keep them alive
        get_app().run(lambda: tasks.extend(_started(program, main.__dict__)))
        current().orchestrator.check_open_run()
    if frames is not None:
        get_app().run(lambda: _press_start(frames))


@contextmanager
def exit_of(script: Path) -> Iterator[None]:
    """Run the body, which executes a script, as Python would: print what it raises, and end with its exit code.

    Raises:
        ScriptEnded: the script failed or called sys.exit; its traceback, from the script on, has been printed.
        ScriptStopped: it was ended from outside.
    """
    try:
        yield
    except ScriptStopped:
        raise
    except SystemExit as ended:
        if code := _exit_code(ended):
            raise ScriptEnded(code, "" if isinstance(ended.code, int) else str(ended.code)) from None
    except (UsdsdgError, KeyboardInterrupt) as error:
        _print_location(error, script)
        raise
    except BaseException as error:  # noqa: BLE001 - scripts may raise anything, and its traceback is printed
        why = _last_line(error, script)
        _print_traceback(error, script)
        raise ScriptEnded(1, why) from None


def _started(program: CodeType, namespace: dict[str, Any]) -> list[asyncio.Task[Any]]:
    """Execute a script; one that awaits outside of functions becomes a task, which is returned."""
    body = eval(program, namespace)
    return [asyncio.ensure_future(body)] if program.co_flags & inspect.CO_COROUTINE else []


def _program(script: Path, namespace: dict[str, Any]) -> CodeType:
    """Compile the script, once the names and the assets that it is sure to use are known to be there.

    namespace: of the script; it gets the names that the editor of Isaac Sim has for it.
    """
    from usdsdg.session.settings.replicator_version import note_old_import
    from usdsdg.writers.journal.run import get_run

    # Of bytes Python reads the encoding itself: a mark of the byte order, or a comment such as `coding: latin-1`.
    tree = ast.parse(get_run().content_of(script), str(script))
    _check_names(script)
    _check_assets(script, tree)
    if reads_packed_colors(tree):
        note_old_import()
    namespace.update({name: importlib.import_module(name) for name in _names_of_the_editor(tree)})
    # Editors and notebooks of Isaac Sim let a script await at its top level. Annotations are strings in this file only.
    return compile(tree, str(script), "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT, dont_inherit=True)


def _names_of_the_editor(tree: ast.AST) -> list[str]:
    """Return those of `carb` and `omni` that the script reads: in Isaac Sim's editor they need no import."""
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return [name for name in ("carb", "omni") if name in read]


def _check_names(script: Path) -> None:
    """Look up the names that the script uses, and warn of those that it may lack.

    Raises:
        Unsupported: the script is sure to fail at some of them; with --lenient this is a warning.
    """
    from usdsdg.cli.script.missing_names import missing_names
    from usdsdg.errors import Unsupported, let_pass

    fatal, possible = missing_names(script)
    for line in possible:
        print(f"warning: {line}", file=sys.stderr)
    if fatal:
        listed = "\n".join(f"  {line}" for line in fatal)
        let_pass(
            Unsupported(
                f"the script was not started, since it uses what usdsdg does not have (--lenient starts it):\n{listed}"
            )
        )


def _check_assets(script: Path, tree: ast.AST) -> None:
    """Look up the assets that the script names.

    Raises:
        MissingAssets: some are missing, and no stand-ins are wanted.
    """
    from usdsdg.cli.script.literal_assets import literal_assets
    from usdsdg.errors import AssetError, Unsupported
    from usdsdg.stage import assets

    if assets.get_on_missing() is not assets.OnMissing.ERROR:
        return
    missing = []
    for each in literal_assets(tree):
        try:
            assets.locate(each.url)
        except (AssetError, Unsupported) as error:
            missing.append(assets.MissingAsset(each.url, assets.where_looked(error), f"{script.name}:{each.line}"))
    if missing:
        raise assets.MissingAssets(assets.listed(missing))


def _press_start(last: int) -> None:
    """Capture frames 0 to `last` of what the script has set up, unless it has captured some itself."""
    from usdsdg import orchestrator
    from usdsdg.session.session import current
    from usdsdg.writers.base import attached_writers

    session = current()
    if not session.observations.frames and (attached_writers() or session.graph.triggers):
        orchestrator.run(num_frames=last + 1)


def _main_module(script: Path) -> ModuleType:
    """Create the script's module as `__main__`, where pickle and others look up its names."""
    main = sys.modules["__main__"] = ModuleType("__main__")
    main.__file__ = str(script)
    return main


def _exit_code(ended: SystemExit) -> int:
    """Return the exit code given to `sys.exit`; as in Python, print any other object and return 1."""
    if ended.code is None or isinstance(ended.code, int):
        return ended.code or 0
    print(ended.code, file=sys.stderr)
    return 1


def _inside(error: BaseException, script: Path) -> list[TracebackType]:
    """Return the entries of the error's traceback that are in the script."""
    return [each for each in _tracebacks(error) if each.tb_frame.f_code.co_filename == str(script)]


def _tracebacks(error: BaseException) -> Iterator[TracebackType]:
    each = error.__traceback__
    while each is not None:
        yield each
        each = each.tb_next


def _print_location(error: BaseException, script: Path) -> None:
    """Print the script's line that failed, and its text."""
    if inside := _inside(error, script):
        line = inside[-1].tb_lineno
        print(f"{script}:{line}: in {inside[-1].tb_frame.f_code.co_name}", file=sys.stderr)
        if text := linecache.getline(str(script), line).strip():
            print(f"    {text}", file=sys.stderr)


def _last_line(error: BaseException, script: Path) -> str:
    """Return the last line of an error's traceback, and the script's line where it was raised."""
    lines = "".join(traceback.format_exception_only(error)).strip().splitlines()
    inside = _inside(error, script)
    return f"{lines[-1]} ({script.name}:{inside[-1].tb_lineno})" if inside else lines[-1]


def _print_traceback(error: BaseException, script: Path) -> None:
    """Print Python's traceback, with suggestions and causes, from the script's first frame on.

    Where no frame is in the script, as for a syntax error, only frames of this file are left out. The last frames are
    left out where they are the import hook's, which only says what is missing.
    """
    from usdsdg.cli.script.usd_errors import remedy

    if note := remedy(error):
        error.add_note(note)
    below = [each for each in _tracebacks(error) if each.tb_frame.f_code.co_filename not in (__file__, ast.__file__)]
    first = next(iter(_inside(error, script) or below), None)
    error.__traceback__ = first
    chained: BaseException | None = error
    while chained is not None:
        chained.__traceback__ = _without_import_hook(chained)
        chained = chained.__cause__ or chained.__context__
    sys.__excepthook__(type(error), error, error.__traceback__)


def _without_import_hook(error: BaseException) -> TracebackType | None:
    from usdsdg.compat import finder

    shown = None
    for each in reversed(list(_tracebacks(error))):
        if each.tb_frame.f_code.co_filename != finder.__file__:
            shown = TracebackType(shown, each.tb_frame, each.tb_lasti, each.tb_lineno)
    return shown
