"""`usdsdg convert IN OUT.usd`: convert a mesh file to a clean USD file."""

from __future__ import annotations

import enum
import sys
from pathlib import Path
from typing import Annotated

import typer

from usdsdg.cli.options.command_context import Quiet, command_context
from usdsdg.cli.options.file_kinds import no_file
from usdsdg.cli.options.output_path import output_path


class OriginOption(enum.StrEnum):
    """Where the origin of the converted asset is."""

    KEEP = "keep"
    CENTER = "center"
    BOTTOM = "bottom"


class UpOption(enum.StrEnum):
    """An up axis."""

    Y = "y"
    Z = "z"


def convert(
    source: Annotated[
        Path, typer.Argument(metavar="IN", help="OBJ, glTF or GLB, PLY, STL, DAE, OFF, FBX, URDF, or captured USDZ.")
    ],
    target: Annotated[Path, typer.Argument(metavar="OUT", help="The .usd, .usda or .usdc to write.")],
    unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of the file: m, cm, mm, inch, foot, or a number of meters.", show_default="what it says, or m"
        ),
    ] = None,
    source_up: Annotated[
        UpOption | None,
        typer.Option("--source-up", help="Up axis of the file.", show_default="what it says, Y, or Z for PLY and STL"),
    ] = None,
    up: Annotated[UpOption, typer.Option(help="Up axis of the USD file.")] = UpOption.Z,
    origin: Annotated[
        OriginOption, typer.Option(help="Where the origin is: where the file has it, or at the center or bottom.")
    ] = OriginOption.KEEP,
    label: Annotated[
        str | None, typer.Option(help="Class of the object; empty for none.", show_default="the name of the file")
    ] = None,
    collider: Annotated[
        str,
        typer.Option(help="none, convexHull, convexDecomposition, meshSimplification, sdf or another of UsdPhysics."),
    ] = "none",
    quiet: Quiet = False,
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
                f"{target}: {size} m, {report.triangles} triangles, {report.parts} parts, {report.materials} materials"
            )
            for line in report.repairs:
                print(f"repaired: {line}")
