"""Files that take the place of missing assets: a labeled box, an empty prim, a gray image, a plain material."""

import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from usdsdg import errors
from usdsdg.operating_system import process_name
from usdsdg.stage.assets import url
from usdsdg.stage.assets.cache_folder import cache_folder
from usdsdg.stage.assets.mesh_files import MESHES

STAGES = (".usd", ".usda", ".usdc", ".usdz", *MESHES)
IMAGES = (".png", ".jpg", ".jpeg", ".hdr", ".exr", ".bmp", ".tga", ".tif", ".tiff")

BOX_METERS = 0.5  # length of the box's sides

_BOX = """#usda 1.0
(
    defaultPrim = "{name}"
    metersPerUnit = {meters_per_unit:g}
)

def Xform "{name}" (
    prepend apiSchemas = ["SemanticsLabelsAPI:class"]
)
{{
    token[] semantics:labels:class = ["{label}"]

    def Mesh "Box" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        float3[] extent = [(-{half:g}, -{half:g}, -{half:g}), ({half:g}, {half:g}, {half:g})]
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5]
        rel material:binding = </{name}/Plain>
        point3f[] points = [{points}]
        uniform token subdivisionScheme = "none"
    }}

    def Material "Plain"
    {{
        token outputs:surface.connect = </{name}/Plain/Shader.outputs:surface>

        def Shader "Shader"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.5, 0.5, 0.5)
            float inputs:roughness = 0.6
            token outputs:surface
        }}
    }}
}}
"""

_EMPTY = """#usda 1.0
(
    defaultPrim = "{name}"
)

def Xform "{name}"
{{
}}
"""

_MATERIAL = """mdl 1.6;
import ::OmniPBR::OmniPBR;
export material {name}(*) = OmniPBR();
"""

_meters_per_unit: Callable[[], float] = lambda: 1.0  # noqa: E731


def set_units(meters_per_unit: Callable[[], float]) -> None:
    """Set the function that gives the meters per unit of the stage into which boxes are referenced."""
    global _meters_per_unit
    _meters_per_unit = meters_per_unit


def name_of(asset: str) -> str:
    """Return the name of an asset: its file name without the extension."""
    return PurePosixPath(url.normalized(asset).rstrip("/")).stem or "asset"


def instead_of(asset: str, *, empty: bool) -> str | None:
    """Return a file in place of a missing asset, made in the user's cache folder; None for other kinds of files.

    Stages are replaced by a box of 0.5 m, labeled with the asset's name as its class, or with `empty` by an Xform;
    images by a gray one, MDL files by OmniPBR with its defaults.

    Raises:
        AssetError: the cache folder cannot be written.
    """
    suffix = PurePosixPath(url.normalized(asset).partition("?")[0]).suffix.lower()
    if suffix in IMAGES:
        return _kept("gray.png", _gray_png())
    if suffix not in (*STAGES, ".mdl"):
        return None
    name = re.sub(r"\W", "_", name_of(asset), flags=re.ASCII)
    name = f"_{name}" if name[0].isdigit() else name
    if suffix == ".mdl":
        return _kept(f"{name}.mdl", _MATERIAL.format(name=name).encode())
    if empty:
        return _kept(f"{name}_empty.usda", _EMPTY.format(name=name).encode())
    units = _meters_per_unit()
    half = BOX_METERS / units / 2
    points = ", ".join(f"({x:g}, {y:g}, {z:g})" for z in (-half, half) for y in (-half, half) for x in (-half, half))
    label = name_of(asset).replace("\\", "/").replace('"', "'")
    box = _BOX.format(name=name, label=label, meters_per_unit=units, half=half, points=points)
    return _kept(f"{name}_{units:g}.usda", box.encode())


def _kept(name: str, contents: bytes) -> str:
    """Write a file of the cache unless it is there with these contents, and return its path."""
    file = cache_folder() / "stand-ins" / name
    try:
        if not file.is_file() or file.read_bytes() != contents:
            file.parent.mkdir(parents=True, exist_ok=True)
            temporary = Path(f"{file}.{process_name()}")
            temporary.write_bytes(contents)
            temporary.replace(file)
    except OSError as error:
        raise errors.AssetError(
            f"stand-ins for missing assets cannot be written to {file.parent}: {error}. Set XDG_CACHE_HOME to a "
            "writable folder."
        ) from error
    return str(file)


def _gray_png() -> bytes:
    """Return a PNG of 2 by 2 pixels, middle gray."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
    rows = (b"\0" + b"\x80" * 6) * 2
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
