"""Readers of mesh files by form; each returns a `MeshFile`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from usdsdg.errors import AssetUnreadable, Unsupported, UsdsdgError
from usdsdg.meshes.model import MeshFile
from usdsdg.meshes.readers import assimp, scenes, urdf
from usdsdg.stage.assets import MESHES

_POINTER = b"version https://git-lfs"

_READERS: dict[str, Callable[[Path], MeshFile]] = {
    **dict.fromkeys((".obj", ".glb", ".gltf", ".ply", ".stl", ".dae", ".off"), scenes.read),
    ".fbx": assimp.read,
    ".urdf": urdf.read,
}

SUFFIXES = MESHES  # the readers of all of them are here
assert set(SUFFIXES) == set(_READERS)


def read(file: Path) -> MeshFile:
    """Read a mesh file.

    Raises:
        AssetUnreadable: it is damaged, empty, or has points but no triangles.
        Unsupported: its form is not known, or needs a package that is not installed.
    """
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise Unsupported(f"{file} is no mesh file; expected {', '.join(SUFFIXES)}")
    with file.open("rb") as stream:
        start = stream.read(len(_POINTER))
    if not start:
        raise AssetUnreadable(f"{file} is an empty file")
    if start == _POINTER:
        raise AssetUnreadable(f"{file} only points to a file in Git LFS; get the file itself with git lfs pull")
    try:
        found = reader(file)
    except UsdsdgError:
        raise
    except Exception as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise AssetUnreadable(f"{file} cannot be read as {file.suffix[1:].upper()}: {text}") from error
    if not any(len(part.triangles) for part in found.parts):
        raise AssetUnreadable(f"{file} has no triangles{' but only points' if found.parts else ''}; give a mesh")
    return found
