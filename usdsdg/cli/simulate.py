"""`usdsdg simulate STAGE`: step the physics of a stage and save where things came to be."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.session import AssetsRoot, Device, Quiet, session


def simulate(
    stage: Annotated[Path, typer.Argument(help="A USD file.")],
    output: Annotated[Path, typer.Argument(help="Where to write the simulated stage.")],
    seconds: Annotated[float, typer.Option(min=0.0, help="Simulated time.")] = 5.0,
    assets_root: AssetsRoot = None,
    device: Device = None,
    quiet: Quiet = False,
) -> None:
    """Simulate a stage for some seconds and save it with the poses at the end."""
    with session(assets_root=assets_root, device=device, quiet=quiet):
        from usdsdg import engines
        from usdsdg.progress import report
        from usdsdg.stage import context

        context.open_stage(stage)
        physics = engines.physics()
        physics.play()
        frames = max(round(seconds * 60), 1)
        for frame in range(frames):
            physics.advance(seconds / frames)
            report("simulating", frame + 1, frames)
        print(context.save_stage(output))
