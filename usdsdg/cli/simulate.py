"""`usdsdg simulate STAGE`: simulate the physics of a stage and save the resulting poses."""

from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.options.command_context import AssetsRoot, Device, Quiet, command_context
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.cli.options.output_path import output_path
from usdsdg.warp_start import quiet_warp


def simulate(
    stage: Annotated[Path, typer.Argument(help="A USD file.")],
    output: Annotated[Path, typer.Argument(help="File of the simulated stage.")],
    seconds: Annotated[float, typer.Option(min=0.0, max=1e6, help="Simulated time in seconds.")] = 5.0,
    settle: Annotated[
        bool, typer.Option("--settle", help="First move overlapping bodies apart and let all come to rest.")
    ] = False,
    assets_root: AssetsRoot = None,
    device: Device = None,
    quiet: Quiet = False,
) -> None:
    """Simulate the physics of a stage and save it with the final poses."""
    with command_context(assets_root=assets_root, device=device, quiet=quiet):
        from usdsdg.errors import OutputNotWritable
        from usdsdg.session import engines, stage_context
        from usdsdg.session.progress import report
        from usdsdg.stage import flatten
        from usdsdg_physics import simulate as simulate_stage

        check_kind(stage, FileKind.STAGE)
        output = output_path(output)
        if output.resolve() == stage.resolve():
            raise OutputNotWritable(f"{output} is the input stage; give the result another name")
        flatten.check_writable(output.absolute())
        quiet_warp()
        opened = stage_context.open_stage(stage)
        simulate_stage(opened, seconds, device=engines.physics_device(), progress=report, settle=settle)
        print(stage_context.save_stage(output))
