"""`usdsdg convert IN OUT.usd`: convert a mesh file to a clean USD file."""

from __future__ import annotations

import enum
import sys
from pathlib import Path

import click

from usdsdg.cli.command import Command, argument
from usdsdg.cli.examples import epilog
from usdsdg.cli.options.command_context import command_context, quiet_option
from usdsdg.cli.options.file_kinds import no_file
from usdsdg.cli.options.output_path import output_path
from usdsdg.cli.options.values import PATH, Member
from usdsdg.errors import counted


class OriginOption(enum.StrEnum):
    """Where the origin of the converted asset is."""

    KEEP = "keep"
    CENTER = "center"
    BOTTOM = "bottom"


class UpOption(enum.StrEnum):
    """An up axis."""

    Y = "y"
    Z = "z"


@click.command(cls=Command, epilog=epilog("convert"))
@argument("source", type=PATH, metavar="IN", help="OBJ, glTF or GLB, PLY, STL, DAE, OFF, FBX, URDF, or captured USDZ.")
@argument("target", type=PATH, metavar="OUT", help="The .usd, .usda or .usdc to write.")
@click.option(
    "--unit",
    help="Unit of the file: m, cm, mm, inch, foot, or a number of meters.",
    show_default="what it says, or m",
)
@click.option(
    "--source-up",
    type=Member(UpOption),
    help="Up axis of the file.",
    show_default="what it says, Y, or Z for PLY and STL",
)
@click.option(
    "--up", type=Member(UpOption), default=UpOption.Z.value, help="Up axis of the USD file.", show_default=True
)
@click.option(
    "--origin",
    type=Member(OriginOption),
    default=OriginOption.KEEP.value,
    help="Where the origin is: where the file has it, or at the center or bottom.",
    show_default=True,
)
@click.option("--label", help="Class of the object; empty for none.", show_default="the name of the file")
@click.option(
    "--collider",
    default="none",
    help="none, convexHull, convexDecomposition, meshSimplification, sdf or another of UsdPhysics.",
    show_default=True,
)
@quiet_option
def convert(
    source: Path,
    target: Path,
    unit: str | None,
    source_up: UpOption | None,
    up: UpOption,
    origin: OriginOption,
    label: str | None,
    collider: str,
    quiet: bool,
) -> None:
    """Convert a mesh file to USD: meters, one up axis, UsdPreviewSurface materials, normals, pictures beside it."""
    with command_context(quiet=quiet):
        from usdsdg.errors import AssetNotFound
        from usdsdg.meshes.conversion import Options
        from usdsdg.meshes.conversion import convert as convert_file
        from usdsdg.meshes.placement import Origin, meters_of

        if not source.is_file():
            raise AssetNotFound(no_file(source))
        options = Options(
            up_axis=up.value.upper(), origin=Origin(origin.value),
            label=source.stem if label is None else label or None,
            source_up_axis=source_up.value.upper() if source_up else None,
            source_unit=None if unit is None else meters_of(unit), collider=None if collider == "none" else collider,
        )  # fmt: skip
        target = output_path(target)
        report, _ = convert_file(source, target, options)
        for line in report.notes:
            print(f"warning: {line}", file=sys.stderr)
        if not quiet:
            size = " x ".join(f"{each:.4g}" for each in report.size)
            print(
                f"{target}: {size} m, {counted(report.triangles, 'triangle')}, {counted(report.parts, 'part')}, "
                f"{counted(report.materials, 'material')}"
            )
            for line in report.repairs:
                print(f"repaired: {line}")
