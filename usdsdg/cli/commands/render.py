"""`usdsdg render STAGE`: render one image of a stage, with its labels."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import (
    assets_root_option,
    command_context,
    device_option,
    quiet_option,
    seed_everything,
    seed_option,
)
from usdsdg.cli.options.file_kinds import FileKind, check_kind
from usdsdg.cli.options.map_option import map_option, use_maps
from usdsdg.cli.options.output_path import output_path
from usdsdg.cli.options.thread_limit import threads_option
from usdsdg.cli.options.values import PATH, PLACE, WholeRange
from usdsdg.errors import OutputNotWritable, StageError

if TYPE_CHECKING:
    from pxr import Usd

_PICTURES = (".png", ".jpg", ".jpeg", ".exr", ".bmp", ".tif", ".tiff")
BLACK = 2  # highest pixel value of an image that counts as black
WHITE = 1500  # luminance that is shown as white [nits]


def _meant(name: str) -> str:
    return "Give --width and --height." if name in ("--resolution", "--size") else ""


@click.command(cls=Command, epilog=epilog("render"), meant=_meant)
@argument("stage", type=PATH, help="A USD file.")
@argument("output", type=PLACE, help="Folder or URL for the images and label arrays.")
@click.option("--camera", help="Path of the camera.", show_default="the stage's first, else one that sees everything")
@click.option("--width", type=WholeRange(min=1), default=640, show_default=True)
@click.option("--height", type=WholeRange(min=1), default=480, show_default=True)
@click.option("--time", type=float, help="Time code to render.", show_default="where the stage's animation begins")
@click.option("--spp", type=WholeRange(min=1, max=1 << 20), default=64, help="Samples per pixel.", show_default=True)
@map_option
@assets_root_option
@device_option
@threads_option
@seed_option
@quiet_option
def render(
    stage: Path,
    output: str,
    camera: str | None,
    width: int,
    height: int,
    time: float | None,
    spp: int,
    map_: tuple[str, ...],
    assets_root: str | None,
    device: str | None,
    threads: int | None,
    seed: int,
    quiet: bool,
) -> None:
    """Render one camera of a stage: image, depth, normals, masks and boxes, in BasicWriter's layout."""
    with command_context(assets_root=assets_root, device=device, threads=threads, quiet=quiet):
        import usdsdg as rep
        from usdsdg.session import stage_context
        from usdsdg.session.stage_times import MOST_SECONDS
        from usdsdg.session.timeline import get_timeline
        from usdsdg.stage.cameras import default_view
        from usdsdg.stores.addresses import is_url

        if time is not None and not math.isfinite(time):
            raise StageError(f"--time {time} is not a time code: give a number")
        check_kind(stage, FileKind.STAGE)
        use_maps(map_, stage)
        if not output:  # as of a variable that is not set
            raise OutputNotWritable("OUTPUT is empty: give a folder, or . for this one")
        if Path(output).suffix.lower() in _PICTURES and not Path(output).is_dir():
            raise OutputNotWritable(
                f"OUTPUT {output} is the name of a picture: give that of a folder, such as {Path(output).stem}, which "
                "gets the picture and its labels"
            )
        place = output if is_url(output) else str(output_path(Path(output)).absolute())
        seed_everything(seed)
        opened = stage_context.open_stage(stage)
        if time is not None:
            seconds = time / get_timeline().get_time_codes_per_seconds()
            if abs(seconds) > MOST_SECONDS:
                raise StageError(f"--time {time} is more than {MOST_SECONDS:g} s from 0: give a time code of the stage")
            get_timeline().set_current_time(seconds)
        path = _camera(opened, width / height, time) if camera is None else camera
        if not default_view.has_light(opened):
            print("the stage has no light: a plain sky and a sun are added for this image", file=sys.stderr)
            default_view.add_sky(opened)
        rep.settings.set_render_pathtraced(spp)
        writer = rep.writers.get("BasicWriter")
        writer.initialize(
            output_dir=place, rgb=True, distance_to_camera=True, distance_to_image_plane=True,
            normals=True, semantic_segmentation=True, instance_id_segmentation=True, bounding_box_2d_tight=True,
            bounding_box_3d=True, camera_params=True,
        )  # fmt: skip
        product = rep.create.render_product(path, (width, height))
        writer.attach(product)
        rgb, radiance = (rep.AnnotatorRegistry.get_annotator(n).attach(product) for n in ("rgb", "HdrColor"))
        rep.orchestrator.step(delta_time=0.0)
        if rgb.get_data()[..., :3].max() <= BLACK:
            print(_why_black(opened, path, float(radiance.get_data()[..., :3].max())), file=sys.stderr)
    print(place)


def _why_black(stage: Usd.Stage, camera: str, brightest: float) -> str:
    """Return what makes an image black, of which the brightest channel of a pixel has so many nits."""
    from usdsdg.stage.cameras import default_view

    if brightest > 0.0:
        lights = default_view.lights(stage)
        shown = ", ".join(lights[:3]) + (" and others" if len(lights) > 3 else "")
        return (
            f"the image is black: its brightest pixel has {brightest:.2g} nits, and white is {WHITE:,}. Lights are "
            f"read in nits, as Isaac Sim does: author larger inputs:intensity or inputs:exposure of {shown}; "
            "labels need no light"
        )
    return (
        f"the image is black: no light reaches what {camera} sees, as outside of a closed hall with lamps. "
        "Author a camera where there is light and pass it as --camera; labels need no light"
    )


def _camera(stage: Usd.Stage, aspect: float, time: float | None) -> str:
    """Return the stage's first camera, or add one that sees the whole stage at a time code."""
    from pxr import Usd

    from usdsdg.stage.cameras import default_view

    cameras = default_view.cameras(stage)
    if cameras:
        return cameras[0]
    print("the stage has no camera: this image shows everything from a three-quarter view", file=sys.stderr)
    return default_view.add_camera(stage, aspect, None if time is None else Usd.TimeCode(time))
