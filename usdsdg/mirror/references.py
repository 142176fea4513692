"""What an asset refers to: layers, payloads, textures, MDL modules, files of meshes, by their text alone."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from pxr import Tf, UsdUtils

from usdsdg.mirror.mesh_references import SUFFIXES, of_mesh
from usdsdg.stage.assets import paths_under_root, scheme_of

UDIM = "<UDIM>"
_TILES = range(1001, 1101)

_MDL_FILES = re.compile(r'"([^"\n]+\.(?:png|jpe?g|exr|hdr|tiff?|tga|bmp|mbsdf|ies|dds))"', re.IGNORECASE)
_MDL_IMPORTS = re.compile(r"^\s*(?:export\s+)?(?:import|using)\s+((?:\.{0,2}::)?\w+(?:::\w+)*)", re.MULTILINE)
_STAGES = (".usd", ".usda", ".usdc")


def references_of(file: Path, path: str) -> list[str]:
    """Return the paths below the root that the content `file` of the path `path` refers to.

    Paths that leave the root, and URLs of other servers, are left out. Modules that belong to Omniverse itself, as
    OmniPBR.mdl does, are in: the root may have them or not.
    """
    suffix = Path(path).suffix.lower()
    if suffix in _STAGES:
        authored: Iterable[str] = _of_stage(file)
    elif suffix == ".mdl":
        authored = _of_mdl(file.read_text(encoding="utf-8", errors="replace"))
    elif suffix in SUFFIXES:
        authored = of_mesh(file, suffix)
    else:
        return []
    folder = posixpath.dirname(path)
    found = (each for text in authored for each in _below_root(text.replace("\\", "/"), folder))
    return list(dict.fromkeys(tile for each in found for tile in _tiles(each)))


def _of_stage(file: Path) -> Iterator[str]:
    try:
        for group in UsdUtils.ExtractExternalReferences(str(file)):
            yield from group
    except Tf.ErrorException:
        return  # damaged, as the stage that opens it will say


def _of_mdl(text: str) -> Iterator[str]:
    yield from (found[1] for found in _MDL_FILES.finditer(text))
    for found in _MDL_IMPORTS.finditer(text):
        # `import ::nvidia::core::*` and `using .::a::b import *`: the last name may be that of a material.
        parts = [part for part in found[1].split("::") if part]
        for depth in range(1, len(parts) + 1):
            if parts[depth - 1] not in (".", ".."):
                yield "/".join(parts[:depth]) + ".mdl"


def _below_root(text: str, folder: str) -> list[str]:
    if scheme_of(text):
        return paths_under_root(text)
    if text.startswith("/"):
        return []
    path = posixpath.normpath(posixpath.join(folder, text.split("[", 1)[0]))
    return [] if path.startswith("..") else [path]


def _tiles(path: str) -> list[str]:
    """Return the files of a path: of <UDIM> all tiles that there may be."""
    return [path.replace(UDIM, str(tile)) for tile in _TILES] if UDIM in path else [path]
