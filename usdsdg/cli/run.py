"""`usdsdg run SCRIPT`: run an existing Replicator or Isaac Sim script, or a Replicator YAML file, unchanged."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Annotated

import typer

from usdsdg.cli.command_context import AssetsRoot, Device, Quiet, SaveStage, Seed, command_context, seed_everything
from usdsdg.cli.file_kinds import FileKind, check_kind

YAML = (".yaml", ".yml")


def run(
    script: Annotated[
        Path,
        typer.Argument(
            metavar="SCRIPT", help="A Python script, standalone or from the Script Editor, or a Replicator YAML file."
        ),
    ],
    arguments: Annotated[
        list[str] | None,
        typer.Argument(metavar="ARGS", help="Arguments of the script, in its sys.argv.", show_default=False),
    ] = None,
    assets_root: AssetsRoot = None,
    device: Device = None,
    seed: Seed = 0,
    save_stage: SaveStage = None,
    quiet: Quiet = False,
) -> None:
    """Run an existing Replicator or Isaac Sim script unchanged, until its asyncio tasks have ended.

    A Replicator YAML file (.yaml, .yml) is run until every trigger with max_execs has run out.

    Options of usdsdg come before SCRIPT; arguments after it belong to the script, except --assets-root and
    --save-stage, which may be given on either side. All arguments after a -- belong to the script.
    """
    arguments, own = _split_own_options(arguments or [])
    assets_root, save_stage = own.get("--assets-root", assets_root), own.get("--save-stage", save_stage)
    if not script.is_file():
        print(f"error: no script {script}", file=sys.stderr)
        raise typer.Exit(1)
    with command_context(assets_root=assets_root, device=device, quiet=quiet, save_stage=save_stage):
        check_kind(script, FileKind.SCRIPT, FileKind.REPLICATOR_YAML)
        seed_everything(seed)
        if script.suffix.lower() in YAML:
            _execute_yaml(script, arguments)
        else:
            execute(script, arguments)


def _split_own_options(arguments: list[str]) -> tuple[list[str], dict[str, Path]]:
    """Split arguments after the script's name into the script's own and the two options of usdsdg."""
    rest, own, given = [], {}, iter(arguments)
    for argument in given:
        name, _, value = argument.partition("=")
        if argument == "--":
            rest += given
        elif name in ("--assets-root", "--save-stage"):
            own[name] = Path(value or next(given, ""))
        else:
            rest.append(argument)
    return rest, own


def execute(script: Path, arguments: list[str]) -> None:
    """Run the script's file as `__main__`, then its asyncio tasks until they end.

    Raises:
        typer.Exit: the script failed or called sys.exit; its traceback, from the script on, has been printed.
    """
    from usdsdg import compat
    from usdsdg.app.app import get_app
    from usdsdg.errors import UsdsdgError
    from usdsdg.session.stage_context import current_stage

    compat.install()
    sys.argv = [str(script), *arguments]
    sys.path.insert(0, str(script.resolve().parent))
    main = _main_module(script)
    current_stage()
    try:
        program = compile(script.read_text(encoding="utf-8"), str(script), "exec")
        get_app().run(lambda: exec(program, main.__dict__))
    except SystemExit as ended:
        if code := _exit_code(ended):
            raise typer.Exit(code) from None
    except (UsdsdgError, KeyboardInterrupt) as error:
        _print_location(error, script)
        raise
    except Exception as error:  # noqa: BLE001 - scripts may raise anything, and its traceback is printed
        _print_traceback(error, script)
        raise typer.Exit(1) from None


def _execute_yaml(script: Path, arguments: list[str]) -> None:
    from usdsdg.errors import ConfigError
    from usdsdg.replicator_yaml import run_file

    if arguments:
        raise ConfigError(f"{script} is a YAML file, which takes no arguments: {' '.join(arguments)}")
    run_file(script)


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
    if inside := _inside(error, script):
        print(f"{script}:{inside[-1].tb_lineno}: in {inside[-1].tb_frame.f_code.co_name}", file=sys.stderr)


def _print_traceback(error: BaseException, script: Path) -> None:
    """Print Python's traceback, with suggestions and causes, from the script's first frame on.

    Where no frame is in the script, as for a syntax error, only frames of this file are left out.
    """
    below = [each for each in _tracebacks(error) if each.tb_frame.f_code.co_filename != __file__]
    first = next(iter(_inside(error, script) or below), None)
    sys.__excepthook__(type(error), error.with_traceback(first), first)
