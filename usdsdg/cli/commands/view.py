"""`usdsdg view SOURCE`: look at a stage, at the frames of a script or job, or at a dataset, in a browser."""

from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import assets_root_option, command_context, device_option, quiet_option
from usdsdg.cli.options.file_kinds import FileKind, kind_of
from usdsdg.cli.options.map_option import map_option, use_maps
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PATH, PLACE, WholeRange
from usdsdg.errors import ConfigError


@click.command(cls=Command, epilog=epilog("view"))
@argument(
    "source",
    type=PATH,
    help="A USD file, a script, a Replicator YAML file, a configuration of a job, or the folder of a dataset.",
)
@argument(
    "arguments",
    nargs=-1,
    type=PLACE,
    metavar="[ARGS]...",
    help="Arguments of the script, or key=value of the configuration.",
)
@click.option(
    "--port",
    type=WholeRange(min=0, max=65535),
    default=0,
    help="Port of the page on 127.0.0.1.",
    show_default="a free one",
)
@map_option
@assets_root_option
@device_option
@threads_option
@click.option("--seed", type=WholeRange(min=0), help="Seed of the run.", show_default="0, or the configuration's")
@quiet_option
def view(
    source: Path,
    arguments: tuple[str, ...],
    port: int,
    map_: tuple[str, ...],
    assets_root: str | None,
    device: str | None,
    threads: int | None,
    seed: int | None,
    quiet: bool,
) -> None:
    """Show a stage, the frames of a script or job, or a dataset on a page of this machine, which a browser opens.

    Drag to orbit, click a thing for its labels and pose, run the triggers again, play the physics.
    Writers write nothing. The address has a random token: nobody else can read the page. Ctrl-C ends it.
    """
    with command_context(assets_root=assets_root, device=device, threads=threads, quiet=quiet, keeps_files=False):
        from usdsdg.view.server import check_installed

        check_installed()
        if not source.exists():
            raise ConfigError(f"there is no {source}: give a USD file, a script, a configuration or a dataset's folder")
        if source.is_dir():
            _show_dataset(source, port)
        else:
            use_maps(map_, source)
            _show(source, list(arguments), seed, port)


def _show(source: Path, arguments: list[str], seed: int | None, port: int) -> None:
    from usdsdg.view.server import Server
    from usdsdg.view.viewer import Viewer

    is_stage = kind_of(source) is FileKind.STAGE
    if is_stage and arguments:
        raise ConfigError(f"{source} is a stage, which takes no arguments: {' '.join(arguments)}")
    if is_stage:
        from usdsdg.view.stages import of_stage

        show = of_stage(source)
    else:
        from usdsdg.view.jobs import of_job

        show = of_job(source, arguments, seed)
    viewer = Viewer(source.name)
    server = Server(viewer.opened, viewer.wake, port=port)
    print(server.address, flush=True)
    try:
        show(viewer)
    finally:
        server.close()


def _show_dataset(folder: Path, port: int) -> None:
    from usdsdg.view.recorded import dataset_page
    from usdsdg.view.server import Server

    server = Server(port=port, answers=dataset_page(folder))
    print(server.address, flush=True)
    try:
        server.wait()
    finally:
        server.close()
