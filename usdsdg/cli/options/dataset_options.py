"""Options about the dataset that a command makes: which frames of it, and what happens to an earlier run."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from usdsdg.cli.options.class_file import class_file
from usdsdg.cli.options.values import NumberRange, WholeRange
from usdsdg.errors import BadValue, counted

if TYPE_CHECKING:
    from usdsdg.writers.journal.growth import Obstacle

resume_option = click.option(
    "--resume", is_flag=True, help="Resume an unfinished run in the output folder, or add frames to one with fewer."
)
overwrite_option = click.option("--overwrite", is_flag=True, help="Remove an earlier run in the output folder.")
shard_option = click.option(
    "--shard", help="Make only the i-th of n parts of the frames, as 0/4; `usdsdg merge` joins them."
)
ray_option = click.option(
    "--ray",
    metavar="[ADDRESS]",
    help="Let actors of Ray make the frames: on this machine, or on the cluster at an address or `auto`.",
)
gpus_per_worker_option = click.option(
    "--gpus-per-worker",
    type=NumberRange(min=0.0, max=1024.0),
    default=0.0,
    help="GPUs of an actor of --ray, such as 0.5.",
    show_default=True,
)
allow_outside_option = click.option(
    "--allow-outside",
    is_flag=True,
    help="Let a YAML graph or a saved stage write anywhere, not only below the folder of relative output folders.",
)
workers_option = click.option(
    "--workers",
    type=WholeRange(min=1),
    help="Let so many processes make the frames, in parts.",
    show_default="this process alone",
)


def begin_run(
    command: str,
    source: Path,
    *,
    arguments: Sequence[str],
    options: Mapping[str, Any] | None = None,
    seed: int | None,
    classes: str | None,
    resume: bool,
    overwrite: bool,
    frames: str | None,
    shard: str | None,
    total: int | None = None,
    more_frames: Obstacle | None = None,
) -> None:
    """Say what this process makes: its recipe, its frames, and what happens to an earlier run.

    options: of the command that decide what is made; those without a value are left out. total: how many frames the
    run has; None: not known. more_frames: tells whether an earlier run is this one with fewer frames.

    Raises:
        BadValue: two options exclude each other, or one has no meaning, as frames that the run does not have.
    """
    from usdsdg.session.session import current
    from usdsdg.writers.formats.shards.reopened import restore_samples
    from usdsdg.writers.journal import recipe
    from usdsdg.writers.journal.earlier_run import Mode
    from usdsdg.writers.journal.growth import MoreFrames
    from usdsdg.writers.journal.portion import Portion

    if resume and overwrite:
        raise BadValue("--resume continues an earlier run and --overwrite removes it: give only one of them")
    if frames is not None and shard is not None:
        raise BadValue("--frames and --shard both choose frames: give only one of them")
    if command == recipe.GENERATE and frames is not None and frames.strip().isdecimal():
        raise BadValue(
            f"--frames {frames!r}: expected A:B, which makes only these frames, such as 0:500. How many a job has is a "
            f"key: --set num_frames={frames.strip()}"
        )
    portion = Portion.of_frames(frames) if frames is not None else None
    if portion is not None and total is not None and portion.first >= total:
        raise BadValue(f"--frames {frames}: the run has {counted(total, 'frame')}, counted from 0; give some of them")
    portion = Portion.of_shard(shard) if shard is not None else portion
    mode = Mode.REPLACE if command == recipe.RUN else Mode.NEW
    mode = Mode.RESUME if resume else Mode.OVERWRITE if overwrite else mode
    made = recipe.Recipe(
        command,
        recipe.source_of(source),
        arguments=[each for each in arguments if not _is_place(each)],
        options={name: value for name, value in (options or {}).items() if value},
        seed=seed,
        classes=_content_of(classes),
    )
    growth = MoreFrames(more_frames, restore_samples, total) if more_frames is not None else None
    current().run.begin(made, mode, portion, source, growth)


def device_facts() -> dict[str, str]:
    """Return what a recipe has of the device that bodies are simulated on: its kind, unless that is the CPU."""
    from usdsdg.session import devices
    from usdsdg.writers.journal.recipe import PHYSICS_DEVICE

    kind = devices.physics_device().partition(":")[0]
    return {PHYSICS_DEVICE: kind} if kind != "cpu" else {}


def _is_place(argument: str) -> bool:
    """Return whether an override of a configuration only says where files go."""
    return argument.partition("=")[0].strip().rsplit(".", 1)[-1] == "output_dir"


def _content_of(classes: str | None) -> str | None:
    """Return what decides the classes: the names that are given, or the content of the file that has them."""
    file = class_file(classes) if classes is not None else None
    if file is None:
        return classes
    file = file / ".usdsdg" / "classes.json" if file.is_dir() else file
    return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else classes
