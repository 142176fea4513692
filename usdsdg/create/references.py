"""References to USD files: `rep.create.from_usd` and `from_dir`."""

import os
from typing import Any

from pxr import Usd

from usdsdg import modify
from usdsdg.arguments.asset_folders import usd_files
from usdsdg.arguments.values import shown
from usdsdg.create.objects import create_objects
from usdsdg.errors import ArgumentError, AssetError, AssetNotFound
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.stage import assets


def from_usd(
    usd: str | os.PathLike, position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, semantics: Any = None, count: int = 1, name: str | None = "Ref", parent: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create `count` references to a USD or mesh file: `/Replicator/Ref_Xform/Ref`.

    Args:
        usd: a file, or a URL below the assets root. Meshes (OBJ, glTF, PLY, STL, DAE, OFF, FBX, URDF) and captured USDZ
            are converted.
        position: in the space of `parent` [stage units]; `scale` are factors and `rotation` angles [degrees]. These,
            `look_at` (a point of the world or prims) and `look_at_up_axis` may be distributions.
        semantics: labels of all, or a list with those of each; default for a mesh its file's name as class.
        name: of the references; their objects are `<parent>/<name>_Xform`, by default below `/Replicator`.

    Raises:
        AssetNotFound: there is no such file; the message names near misses. AssetError: it cannot be referenced.
        BadPrim: `parent` is not on the stage. ArgumentError: a value has another shape.
    """
    if not isinstance(usd, (str, os.PathLike)):
        several = isinstance(usd, (ReplicatorItem, list, tuple))
        hint = ". randomizer.instantiate(paths, size) draws from several files" if several else ""
        raise ArgumentError(f"create.from_usd: usd is {shown(usd)}; expected the path or URL of a file{hint}")
    file = assets.resolve_object(usd, labeled=semantics is None)

    def define(stage: Usd.Stage, path: str) -> None:
        if not stage.DefinePrim(path).GetReferences().AddReference(file):
            raise AssetError(f"create.from_usd: {file} cannot be referenced at {path}")

    return create_objects(
        "Ref", define, position=position, scale=scale, rotation=rotation, look_at=look_at,
        look_at_up_axis=look_at_up_axis, semantics=semantics, node="OgnCreateFromUsd", name=name, parent=parent,
        count=count,
    )  # fmt: skip


def from_dir(
    dir_path: str | os.PathLike, recursive: bool = False, path_filter: str | None = None, semantics: Any = None
) -> ReplicatorItem:
    """Create one reference to each USD and mesh file of a folder, sorted by path.

    Args:
        dir_path: a folder, or a URL below the assets root.
        recursive: also search the subfolders.
        path_filter: regular expression that must be found in the path.
        semantics: labels of all, or a list of one per file; default for meshes the names of their files.

    Raises:
        AssetNotFound: there is no such folder, or no file that matches.
        ArgumentError: `path_filter` is not a regular expression.
    """
    found = usd_files(dir_path, recursive=recursive, path_filter=path_filter)
    if not found:
        raise AssetNotFound(
            f"create.from_dir: {dir_path} has no USD or mesh file"
            + (f" that matches {path_filter!r}" if path_filter else "")
        )
    # Labels follow below; these only keep a mesh from being labeled by its name.
    unlabeled = None if semantics is None else {}
    made = [path for file in found for path in from_usd(file, semantics=unlabeled).prims]
    item = ReplicatorItem(Node(kind="OgnGroup", prims=tuple(made)))
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item
