"""`usdsdg generate CONFIG`: run a job from its YAML or JSON file, or the graph of a saved stage."""

import time
from collections.abc import Sequence
from pathlib import Path

import click

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
    semantic_classes_option,
)
from usdsdg.cli.options.dataset_options import (
    allow_outside_option,
    begin_run,
    device_facts,
    gpus_per_worker_option,
    overwrite_option,
    ray_option,
    resume_option,
    shard_option,
    workers_option,
)
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.cli.options.map_option import map_option, use_maps, with_whole_paths
from usdsdg.cli.options.rerun_option import recorded, rerun_option
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PATH, WholeRange
from usdsdg.cli.part import run_here
from usdsdg.errors import BadValue, counted

# Threads of an actor of Ray, unless --threads says otherwise; parts for each, so that none waits long for the others.
RAY_THREADS, PARTS_ON_RAY = 2, 4
# Options that name the output folder in other programs.
_FOLDERS = ("o", "out", "output", "output_dir", "output_folder", "output_path")
# Options that name the configuration in other programs.
_FILES = ("c", "config", "config_file", "f", "file")


def _meant(name: str) -> str:
    """Return how a key of configurations is set, where it was given as an option or argument."""
    from usdsdg.scenarios.jobs import keys_of_jobs

    if name.rstrip().endswith(("]", "}")) and "=" not in name:  # the second half of --set key=[1, 2]
        return "Quote what has blanks: --set 'resolution=[320, 240]'"
    key, equals, value = name.lstrip("-").replace("-", "_").partition("=")
    if key in _FOLDERS:
        given = value if equals else "..."
        of_writer = f"--set writer_kwargs.output_dir={given}"
        return f"The folder of the dataset is a key: --set output_dir={given}, in object-based jobs {of_writer}"
    if key in _FILES:
        return f"The configuration is given without an option: usdsdg generate {value or 'job.yaml'}"
    if key.partition(".")[0] not in keys_of_jobs():
        return ""
    return f"Keys of the configuration are set by --set {key}={value if equals else '...'}"


@click.command(cls=Command, epilog=epilog("generate"), meant=_meant)
@argument("config", type=PATH, help="Configuration such as configs/detection.yaml, or a .usd saved with its graph.")
@click.option(
    "--set",
    "set_",
    multiple=True,
    metavar="KEY=VALUE",
    help="Override a key, such as num_frames=3 or camera.field_of_view=60; repeatable, one key each.",
)
@map_option
@assets_root_option
@device_option
@physics_device_option
@threads_option
@click.option("--seed", type=WholeRange(min=0), help="Seed of the run.", show_default="the config's")
@semantic_classes_option
@click.option("--frames", help="Make only these frames, as 0:500; `usdsdg merge` joins them.")
@shard_option
@workers_option
@ray_option
@gpus_per_worker_option
@resume_option
@overwrite_option
@allow_outside_option
@save_stage_option
@rerun_option
@inspect_option
@quiet_option
def generate(
    config: Path,
    set_: tuple[str, ...],
    map_: tuple[str, ...],
    assets_root: str | None,
    device: str | None,
    physics_device: str,
    threads: int | None,
    seed: int | None,
    semantic_classes: str | None,
    frames: str | None,
    shard: str | None,
    workers: int | None,
    ray: str | None,
    gpus_per_worker: float,
    resume: bool,
    overwrite: bool,
    allow_outside: bool,
    save_stage: Path | None,
    rerun: str | None,
    inspect: bool,
    quiet: bool,
) -> None:
    """Generate a dataset from a config file: object-based, detection or bin picking.

    Given a stage that a script saved, run its graph again without the script.
    """
    with (
        command_context(
            assets_root=assets_root,
            device=device,
            physics_device=physics_device,
            threads=threads,
            quiet=quiet,
            save_stage=save_stage,
        ),  # fmt: skip
        recorded(rerun, workers=workers is not None or ray is not None),
    ):
        from usdsdg.scenarios import earlier_runs, jobs, saved_pipeline
        from usdsdg.scenarios.shared.input_folders import folder_facts

        check_kind(config, FileKind.CONFIGURATION, FileKind.STAGE)
        use_maps(map_, config)
        if ray is not None:  # before an earlier run is removed
            from usdsdg.workers import ray_cluster

            ray_cluster.check_installed()
        elif gpus_per_worker:
            raise BadValue("--gpus-per-worker is of the actors of --ray: give both, or neither")
        overrides = [*set_, *([f"seed={seed}"] if seed is not None else [])]
        is_stage = config.suffix.lower() in saved_pipeline.SUFFIXES
        loaded = None if is_stage else jobs.load_job(config, overrides)
        folders = folder_facts(loaded[1]) if loaded is not None else {}
        begin_run(
            "generate", config, arguments=overrides, options=device_facts() | folders,
            seed=loaded[1].seed if loaded is not None else seed, classes=semantic_classes,
            resume=resume, overwrite=overwrite, frames=frames, shard=shard,
            total=loaded[1].num_frames if loaded is not None else None,
            more_frames=earlier_runs.of_stage if loaded is None else earlier_runs.of_job(config, *loaded),
        )  # fmt: skip
        fix_classes(semantic_classes)
        if workers is not None or ray is not None:
            place = (ray, gpus_per_worker) if ray is not None else None
            _let_workers_make(
                config, overrides, workers, place, frames or shard, maps=map_, assets_root=assets_root, device=device,
                physics_device=physics_device, threads=threads, semantic_classes=semantic_classes,
                save_stage=save_stage,
            )  # fmt: skip
        elif loaded is None:
            saved_pipeline.run(config, saved_pipeline.Overrides.parse(overrides), allow_outside=allow_outside)
        else:
            job, options = loaded
            seed_everything(options.seed)
            job.run(options)
        finish_files()
        show_written(inspect=inspect)


def make_part(arguments: Sequence[str]) -> tuple[int, str]:
    """Run `usdsdg generate` in this process, which makes several parts; return its exit code and what it printed."""
    return run_here(generate, arguments[1:])


def _let_workers_make(
    config: Path,
    overrides: Sequence[str],
    count: int | None,
    cluster: tuple[str, float] | None,
    chosen: str | None,
    *,
    maps: Sequence[str],
    threads: int | None,
    save_stage: Path | None,
    **options: str | None,
) -> None:
    """Let several processes make the dataset.

    count: of processes. cluster: the address of one of Ray, and the GPUs of an actor; None: this machine.
    chosen: frames, if the user has chosen any. options: of the command, which the processes get as well.

    Raises:
        BadValue: an option has no meaning for several processes.
    """
    from usdsdg.parallel import available_threads
    from usdsdg.scenarios import jobs
    from usdsdg.session.session import current
    from usdsdg.workers.dataset import make_dataset, on_ray, on_this_machine
    from usdsdg.workers.ray_cluster import Resources

    if chosen is not None or save_stage is not None:
        option = "--workers" if cluster is None else "--ray"
        raise BadValue(f"{option} makes all frames: it cannot be given with --frames, --shard or --save-stage")
    job, values = jobs.load_job(config, overrides)
    each = threads or (max(1, available_threads() // (count or 1)) if cluster is None else RAY_THREADS)
    arguments = ["generate", str(config.absolute()), "--threads", str(each)]
    for override in overrides:
        arguments += ["--set", override]
    for each_map in with_whole_paths(maps):
        arguments += ["--map", each_map]
    for name, value in options.items():
        arguments += [f"--{name.replace('_', '-')}", value] if value is not None else []
    if cluster is None:
        assert count is not None
        make, pieces = on_this_machine(arguments, count), count
    else:
        address, gpus = cluster
        pieces = PARTS_ON_RAY * (count or 1)
        make = on_ray(arguments, count, make_part, address=address, resources=Resources(each, gpus))
    current().run.shares_out = True  # already where the places are checked, which may have parts
    places, started = job.places(values), time.perf_counter()
    make_dataset(places, values.num_frames, pieces, make, unit=job.episode(values))
    print(f"{counted(values.num_frames, 'frame')} in {time.perf_counter() - started:.1f} s")
    for place in places:
        print(f"dataset: {place}")
