"""`usdsdg simulate STAGE`: simulate the physics of a stage and save the resulting poses."""

from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import assets_root_option, command_context, quiet_option
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.cli.options.map_option import map_option, use_maps
from usdsdg.cli.options.output_path import output_path
from usdsdg.cli.options.values import PATH, NumberRange
from usdsdg.warp_start import quiet_warp


@click.command(cls=Command, epilog=epilog("simulate"))
@argument("stage", type=PATH, help="A USD file.")
@argument("output", type=PATH, help="File of the simulated stage.")
@click.option(
    "--seconds",
    type=NumberRange(min=0.0, max=1e6),
    default=5.0,
    help="Simulated time in seconds.",
    show_default=True,
)
@click.option("--settle", is_flag=True, help="First move overlapping bodies apart and let all come to rest.")
@map_option
@assets_root_option
@click.option("--device", help="Where bodies are simulated: cpu or cuda:0.", default="cpu", show_default=True)
@quiet_option
def simulate(
    stage: Path,
    output: Path,
    seconds: float,
    settle: bool,
    map_: tuple[str, ...],
    assets_root: str | None,
    device: str,
    quiet: bool,
) -> None:
    """Simulate the physics of a stage and save it with the final poses."""
    with command_context(assets_root=assets_root, physics_device=device, quiet=quiet):
        from usdsdg.errors import OutputNotWritable
        from usdsdg.session import devices, stage_context
        from usdsdg.session.progress import report
        from usdsdg.stage import assets, flatten
        from usdsdg_physics import simulate as simulate_stage

        check_kind(stage, FileKind.STAGE)
        use_maps(map_, stage)
        output = output_path(output)
        if output.resolve() == stage.resolve():
            raise OutputNotWritable(f"{output} is the input stage; give the result another name")
        flatten.check_writable(output.absolute())
        quiet_warp()
        opened = stage_context.open_stage(stage)
        assets.check_missing(opened)
        simulate_stage(opened, seconds, device=devices.physics_device(), progress=report, settle=settle)
        print(stage_context.save_stage(output))
