"""`usdsdg run SCRIPT`: run an existing Replicator or Isaac Sim script, or a Replicator YAML file, unchanged."""

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from itertools import takewhile
from pathlib import Path

import click
from click.exceptions import Exit

from usdsdg.cli.command import Command, argument
from usdsdg.cli.commands.inspect import inspect_option, show_written
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import (
    assets_root_option,
    command_context,
    device_option,
    finish_files,
    fix_classes,
    physics_device_option,
    quiet_option,
    save_stage_option,
    seed_everything,
    seed_option,
    semantic_classes_option,
)
from usdsdg.cli.options.dataset_options import (
    allow_outside_option,
    begin_run,
    device_facts,
    overwrite_option,
    resume_option,
    shard_option,
    workers_option,
)
from usdsdg.cli.options.file_kinds import YAML, FileKind, check_kind, check_script, no_file
from usdsdg.cli.options.map_option import map_option
from usdsdg.cli.options.rerun_option import recorded, rerun_option
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PATH, PLACE, Member, WholeRange
from usdsdg.cli.script.conditions import Conditions, MissingOption, NewStageOption, ReplicatorOption
from usdsdg.cli.script.interpreter import interpreter_restored
from usdsdg.cli.script.workers import ScriptWorkers, caught_code, check_part
from usdsdg.errors import BadValue

# Options that may be given before and after the script.
_ON_EITHER_SIDE = ("--assets-root", "--save-stage")


# Options after the script's name belong to the script.
@click.command(cls=Command, context_settings={"allow_interspersed_args": False}, epilog=epilog("run"))
@argument(
    "script",
    type=PATH,
    help="A Python script, standalone or from the Script Editor, or a Replicator YAML file.",
)
@argument("arguments", nargs=-1, type=PLACE, metavar="[ARGS]...", help="Arguments of the script, in its sys.argv.")
@click.option("--stage", type=PATH, help="Open this stage first, as the one that is open in the GUI.")
@click.option(
    "--new-stage",
    type=Member(NewStageOption),
    help="What new stages hold: a new stage of Omniverse Code (kit: Y up, centimeters, a light) or of Isaac Sim "
    "(isaac: Z up, meters, a light).",
    show_default="empty, Z up, meters",
)
@click.option(
    "--frames",
    metavar="N|A:B",
    help="A number: if the script starts no run, or one that nothing ends, capture frames 0 to this one, as after a "
    "press on Start in the GUI. With A:B, make the frames from A up to B; `usdsdg merge` joins them.",
)
@shard_option
@click.option("--part", hidden=True, help="A:B, as --frames, of a process of --workers.")
@workers_option
@resume_option
@overwrite_option
@map_option
@click.option(
    "--missing-assets",
    type=Member(MissingOption),
    default=MissingOption.ERROR.value,
    help="Missing assets are an error, labeled boxes that stand in for them, or left out.",
    show_default=True,
)
@click.option(
    "--lenient", is_flag=True, help="Warn of what Replicator lets pass, and of errors that the script catches."
)
@click.option(
    "--replicator",
    type=Member(ReplicatorOption),
    help="Generation of Replicator that the script was written for.",
    show_default="seen from its imports",
)
@semantic_classes_option
@assets_root_option
@device_option
@physics_device_option
@threads_option
@click.option(
    "--worlds",
    type=WholeRange(min=1),
    default=1,
    help="Draw and path-trace so many frames together, where the graph alone decides what they show; the files are "
    "the same. A script that captures frame by frame makes so many at each step.",
    show_default=True,
)
@seed_option
@allow_outside_option
@save_stage_option
@rerun_option
@inspect_option
@quiet_option
def run(
    script: Path,
    arguments: tuple[str, ...],
    stage: Path | None,
    new_stage: NewStageOption | None,
    frames: str | None,
    shard: str | None,
    part: str | None,
    workers: int | None,
    resume: bool,
    overwrite: bool,
    map_: tuple[str, ...],
    missing_assets: MissingOption,
    lenient: bool,
    replicator: ReplicatorOption | None,
    semantic_classes: str | None,
    assets_root: str | None,
    device: str | None,
    physics_device: str,
    threads: int | None,
    worlds: int,
    seed: int,
    allow_outside: bool,
    save_stage: Path | None,
    rerun: str | None,
    inspect: bool,
    quiet: bool,
) -> None:
    """Run an existing Replicator or Isaac Sim script unchanged, until its asyncio tasks have ended.

    A Replicator YAML file (.yaml, .yml) is run until every trigger with max_execs has run out.

    Options of usdsdg come before SCRIPT; arguments after it belong to the script, except --assets-root and
    --save-stage, which may be given on either side. All arguments after a -- belong to the script.
    """
    own_arguments, own = _split_own_options(arguments)
    assets_root = own.get("--assets-root", assets_root)
    save_stage = Path(own["--save-stage"]) if "--save-stage" in own else save_stage
    if not script.is_file():
        print(f"error: {no_file(script)}", file=sys.stderr)
        raise Exit(1)
    with (
        interpreter_restored(),
        command_context(
            assets_root=assets_root,
            device=device,
            physics_device=physics_device,
            threads=threads,
            quiet=quiet,
            save_stage=save_stage,
        ),  # fmt: skip
        recorded(rerun, workers=workers is not None),
    ):
        from usdsdg.cli.script.kept_datasets import datasets_kept
        from usdsdg.cli.script.outcome import reported_outcome
        from usdsdg.session.session import current
        from usdsdg.writers.journal.growth import more_frames_of_option

        _remark_on_own_options(script, arguments)
        check_script(script)
        if stage is not None:
            check_kind(stage, FileKind.STAGE)
        last, portion = _frames(frames)
        portion = part or portion
        if workers is not None and (portion or shard or save_stage):
            raise BadValue("--workers makes all frames: it cannot be given with --frames A:B, --shard or --save-stage")
        conditions = Conditions(stage, new_stage, last, replicator, map_, missing_assets, lenient)
        begin_run(
            "run", script, arguments=own_arguments, options=conditions.facts() | device_facts(), seed=seed,
            classes=semantic_classes, resume=resume, overwrite=overwrite, frames=portion, shard=shard,
            more_frames=more_frames_of_option,
        )  # fmt: skip
        seed_everything(seed)
        fix_classes(semantic_classes)
        maker = None
        if workers is not None:
            maker = ScriptWorkers(
                script, own_arguments, workers, conditions, threads=threads, allow_outside=allow_outside, worlds=worlds,
                semantic_classes=semantic_classes, assets_root=assets_root, device=device,
                physics_device=physics_device, seed=seed,
            )  # fmt: skip
        conditions.apply(script)
        current().frames_together = worlds if workers is None else 1  # which only counts frames
        # All frames are not made here, so a script that removes its folder first would lose the others.
        kept = datasets_kept() if resume or portion or shard else nullcontext()
        with reported_outcome(caught_code=1 if part is None else caught_code()), kept:
            execute_script(script, own_arguments, last, allow_outside=allow_outside)
            if current().run.is_copy:
                raise Exit(0)  # of a process that the script has forked, and that has come to its end here, too
            finish_files()
            if part is not None:
                check_part()
        if maker is not None:
            maker.make()
        show_written(inspect=inspect)


def execute_script(script: Path, arguments: list[str], frames: int | None, *, allow_outside: bool) -> None:
    """Execute a Python script or a Replicator YAML file in the session as it is; see `execute` for `frames`.

    allow_outside: whether a YAML file may say that output goes elsewhere than below the root of relative folders.
    """
    from usdsdg.cli.script.execution import execute

    if script.suffix.lower() in YAML:
        _execute_yaml(script, arguments, allow_outside)
    else:
        execute(script, arguments, frames=frames)


def _frames(text: str | None) -> tuple[int | None, str | None]:
    """Return the last frame of a run that nothing ends, and the frames to make; None for what is not given."""
    if text is None or ":" in text:
        return None, text
    if not text.isdigit():
        raise BadValue(f"--frames {text!r}: expected a number, 0 or more, or A:B, such as 0:500")
    return int(text), None


def _split_own_options(arguments: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Split arguments after the script's name into the script's own and the two options of usdsdg."""
    rest, own, given = [], {}, iter(arguments)
    for word in given:
        name, _, value = word.partition("=")
        if word == "--":
            rest += given
        elif name in _ON_EITHER_SIDE:
            own[name] = value or next(given, "")
        else:
            rest.append(word)
    return rest, own


def _remark_on_own_options(script: Path, after: Sequence[str]) -> None:
    """Say which options of usdsdg after the script it gets as its own, although it does not mention them.

    after: all arguments after the script; those after a -- are meant for it.

    Raises:
        BadValue: --resume is one of them: without it the run would remove the frames that are to be kept.
    """
    own = {name for each in run.params for name in each.opts if name.startswith("--")} - set(_ON_EITHER_SIDE)
    given = [name for name in (each.partition("=")[0] for each in takewhile("--".__ne__, after)) if name in own]
    text = script.read_text(encoding="utf-8", errors="replace") if given else ""
    for name in given:
        if name == "--resume" and name not in text:
            raise BadValue(
                f"--resume is passed to {script}, which does not mention it, and the run would begin again. Give it "
                f"before the script: usdsdg run --resume {script}. After a -- it is the script's own."
            )
        if name not in text:
            print(
                f"remark: {name} is passed to {script}, which does not mention it. Options of usdsdg come before the "
                f"script: usdsdg run {name} ... {script}",
                file=sys.stderr,
            )


def _execute_yaml(script: Path, arguments: list[str], allow_outside: bool) -> None:
    from usdsdg.errors import ConfigError
    from usdsdg.replicator_yaml import run_file
    from usdsdg.session.confinement import confined
    from usdsdg.writers.backends.disk import disk_root

    if arguments:
        raise ConfigError(f"{script} is a YAML file, which takes no arguments: {' '.join(arguments)}")
    with confined(None if allow_outside else disk_root()):
        run_file(script)
