"""Readers of mesh files by form; each returns a `MeshFile`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from usdsdg.errors import AssetUnreadable, Unsupported, UsdsdgError
from usdsdg.meshes.model import MeshFile
from usdsdg.meshes.readers import assimp, scenes, urdf, usd
from usdsdg.stage.assets import MESHES, PACKAGE, not_a_file_of_its_own

USD = (".usd", ".usda", ".usdc")

_READERS: dict[str, Callable[[Path], MeshFile]] = {
    **dict.fromkeys((".obj", ".glb", ".gltf", ".ply", ".stl", ".dae", ".off"), scenes.read),
    ".fbx": assimp.read,
    ".urdf": urdf.read,
    **dict.fromkeys((PACKAGE, *USD), usd.read),
}

SUFFIXES = (*MESHES, PACKAGE, *USD)  # the readers of all of them are here
assert set(SUFFIXES) == set(_READERS)


# Errors of readers that say nothing of the file to a person.
_INTERNAL = (
    AttributeError, AssertionError, IndexError, KeyError, RecursionError, TypeError, UnboundLocalError, UnicodeError,
    json.JSONDecodeError,
)  # fmt: skip


def _why(error: Exception) -> str:
    text = " ".join(str(error).split())
    if not text or isinstance(error, _INTERNAL):
        return f"it is damaged, or not what its name says ({type(error).__name__}{f': {text}' if text else ''})"
    return text


def read(file: Path) -> MeshFile:
    """Read a mesh file.

    Raises:
        AssetUnreadable: it is damaged, empty, or has points but no triangles.
        Unsupported: its form is not known, or needs a package that is not installed.
    """
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise Unsupported(f"{file} is no mesh file; expected {', '.join(SUFFIXES)}")
    if why := not_a_file_of_its_own(file):
        raise AssetUnreadable(f"{file} {why}")
    try:
        found = reader(file)
    except UsdsdgError:
        raise
    except Exception as error:
        raise AssetUnreadable(f"{file} cannot be read as {file.suffix[1:].upper()}: {_why(error)}") from error
    if not any(len(part.triangles) for part in found.parts):
        raise AssetUnreadable(f"{file} has no triangles{' but only points' if found.parts else ''}; give a mesh")
    return found
