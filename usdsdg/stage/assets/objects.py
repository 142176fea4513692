"""Assets that are referenced as one object: opened before they are, so that a broken file is an error at once."""

from __future__ import annotations

import os

from pxr import Sdf, Tf

from usdsdg import errors
from usdsdg.stage.assets import mesh_files, missing
from usdsdg.stage.assets.file_checks import check_file, check_neighbors, not_a_file_of_its_own
from usdsdg.stage.usd_errors import reason

# The latest file that was opened; a reference that follows does not read it again.
_latest: Sdf.Layer | None = None


def forget_latest() -> None:
    """Let go of the file that was opened last: a new stage reads it again, which may have changed."""
    global _latest
    _latest = None


def resolve_object(
    asset: str | os.PathLike[str], *, labeled: bool = False, remedy: str = "author one, or its reference shows nothing"
) -> str:
    """Return the file of an asset that is to be referenced, as `resolve` does, after checking that it can be.

    A captured .usdz, which holds meshes and nothing else, is converted as a mesh file is.

    labeled: what is converted gets the name of its file as its class. remedy: what to do without a default prim.

    Raises:
        AssetNotFound, AssetError, Unsupported: as `resolve`.
        AssetUnreadable: it is damaged. AssetError: it has no default prim, so that a reference would show nothing.
    """
    file = mesh_files.as_object(missing.located(asset), labeled=labeled)
    layer = open_layer(file)
    if not layer.defaultPrim:
        names = ", ".join(spec.path.pathString for spec in layer.rootPrims) or "no prims"
        raise errors.AssetError(f"{file} has no default prim; {remedy} (it has {names})")
    return file


def resolve_reference(asset: str | os.PathLike[str], prim_path: str) -> str:
    """Return the file that a prim is to refer to, as `resolve` does, after checking that it opens.

    Raises:
        AssetNotFound, AssetError, Unsupported: as `resolve`. AssetUnreadable: it is damaged. The message has the prim.
    """
    try:
        file = missing.resolve(asset)
        open_layer(file)
    except (errors.AssetError, errors.Unsupported) as error:
        remedy = "; replace the file, or export it again" if isinstance(error, errors.AssetUnreadable) else ""
        error.args = (f"{prim_path} cannot refer to {os.fspath(asset)}: {error}{remedy}",)
        raise
    return file


def open_layer(file: str) -> Sdf.Layer:
    """Open a USD file.

    Raises:
        AssetUnreadable: it is damaged, empty, a folder, or not USD.
    """
    global _latest
    if os.path.isdir(file):
        raise errors.AssetUnreadable(f"{file} cannot be opened as USD: it is a folder")
    check_file(file)
    if why := not_a_file_of_its_own(file):
        raise errors.AssetUnreadable(f"{file} {why}")
    try:
        layer = Sdf.Layer.FindOrOpen(file)
    except Tf.ErrorException as failure:
        raise errors.AssetUnreadable(f"{file} cannot be opened as USD: {reason(failure)}") from failure
    if layer is None:
        raise errors.AssetUnreadable(f"{file} cannot be opened as USD: it is damaged or cut off")
    check_neighbors(layer)
    _latest = layer
    return layer
