"""Mesh files in place of USD files: who converts them, and where the result is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath

MESHES = (".obj", ".glb", ".gltf", ".ply", ".stl", ".dae", ".off", ".fbx", ".urdf")
PACKAGE = ".usdz"

# (file, label) to the path of a USD file.
Converter = Callable[[str, str | None], str]

_converter: Converter | None = None


def set_mesh_converter(converter: Converter) -> None:
    """Set the function that converts mesh files."""
    global _converter
    _converter = converter


def is_mesh(path: str) -> bool:
    """Whether a path ends like a mesh file."""
    return PurePath(path).suffix.lower() in MESHES


def as_object(file: str, *, labeled: bool) -> str:
    """Return what is referenced for an object: as `as_usd`, and of a captured .usdz the clean USD file."""
    if PurePath(file).suffix.lower() == PACKAGE and _converter is not None:
        return _converter(file, PurePath(file).stem if labeled else None)
    return as_usd(file, labeled=labeled)


def as_usd(file: str, *, labeled: bool) -> str:
    """Return the USD file of a mesh file, with its name as its class if `labeled`; other files as they are."""
    if not is_mesh(file) or _converter is None:
        return file
    return _converter(file, PurePath(file).stem if labeled else None)
