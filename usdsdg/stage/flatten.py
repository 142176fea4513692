"""Saving of a stage as one layer: sublayers and session layer are merged, references stay."""

import contextlib
import errno
import os
import re
from pathlib import Path

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from usdsdg import errors
from usdsdg.operating_system import process_name
from usdsdg.stage.assets import anchors
from usdsdg.stage.assets.url import is_utf8
from usdsdg.stage.usd_errors import reason

EXTENSIONS = (".usd", ".usda", ".usdc")

_UDIM = re.compile(r"<UDIM>|<UVTILE\d>", re.IGNORECASE)


def write(stage: Usd.Stage, path: Path) -> Path:
    """Write `stage` to `path` atomically; see `write_layer` for the errors."""
    return write_layer(flattened(stage, path.parent), path)


def write_layer(layer: Sdf.Layer, path: Path) -> Path:
    """Write `layer` to `path` atomically: under a temporary name, then renamed.

    Raises:
        Unsupported: the extension is not .usd, .usda or .usdc.
        OutputNotWritable: the folder or file cannot be written.
    """
    check_writable(path)
    temporary = _temporary(path)
    try:
        if not layer.Export(str(temporary)):
            raise OSError(f"USD could not write {temporary.name}")
        temporary.replace(path)
    except (OSError, Tf.ErrorException) as failure:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise _not_writable(path, failure) from failure
    return path


def check_writable(path: Path) -> None:
    """Make the folder of `path`, and check that a stage can be saved there.

    Raises:
        Unsupported: the extension is not .usd, .usda or .usdc.
        OutputNotWritable: the folder or file cannot be written.
    """
    check_extension(path)
    if not is_utf8(str(path)):
        raise errors.OutputNotWritable(f"{str(path)!r} is not UTF-8, as USD needs paths to be. Choose another path.")
    probe = _temporary(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, "a folder of that name is in the way")
    except OSError as failure:
        raise _not_writable(path, failure) from failure


def _temporary(path: Path) -> Path:
    return path.with_name(f".{path.stem}.{process_name()}{path.suffix.lower()}")


def _not_writable(path: Path, failure: OSError | Tf.ErrorException) -> errors.OutputNotWritable:
    why = reason(failure) if isinstance(failure, Tf.ErrorException) else failure.strerror or str(failure)
    return errors.OutputNotWritable(f"the stage cannot be saved to {path}: {why}. Choose another path.")


def check_extension(path: Path) -> None:
    """Raise Unsupported unless the extension is that of a USD file."""
    extension = path.suffix.lower()
    if extension not in EXTENSIONS:
        remedy = "; usdzip packs a saved stage as .usdz" if extension == ".usdz" else ""
        raise errors.Unsupported(f"cannot save a stage as {path.name!r}: use one of {', '.join(EXTENSIONS)}{remedy}")


def flattened(stage: Usd.Stage, folder: Path) -> Sdf.Layer:
    """Return the stage's own layers, session layer strongest, as one anonymous layer for a file in `folder`."""
    return UsdUtils.FlattenLayerStack(stage, lambda layer, path: portable_path(layer, path, folder), "usdsdg.usda")


def portable_path(layer: Sdf.Layer, asset_path: str, folder: Path) -> str:
    """Convert `asset_path`, authored in `layer`, for a file in `folder`.

    Paths of files in `folder` or below become relative, so that the folder can be moved as a whole; those of other
    files become absolute. Absolute paths, URLs and names without a file (`OmniPBR.mdl`) stay as they are.
    """
    if not asset_path or os.path.isabs(asset_path) or "://" in asset_path:
        return asset_path
    if Sdf.Layer.IsAnonymousLayerIdentifier(asset_path):
        errors.warn_once(
            f"the saved stage refers to the layer {asset_path}, which exists in memory only and is not saved"
        )
        return asset_path
    absolute = layer.ComputeAbsolutePath(asset_path)
    if layer.anonymous or not (asset_path.startswith(".") or _exists(absolute)):
        absolute = _in_working_folder(asset_path)
        if absolute:
            anchors.note_working_folder()
    if not absolute:
        return asset_path
    inside = os.path.relpath(absolute, folder)
    return absolute if inside.startswith("..") else f"./{Path(inside).as_posix()}"


def _in_working_folder(path: str) -> str:
    """Return where a relative path leads from the working folder; "" if no file is there that USD could name."""
    try:
        absolute = os.path.abspath(path)
    except FileNotFoundError:  # a script may have removed the folder that it has gone to
        return ""
    return absolute if is_utf8(absolute) and _exists(absolute) else ""


def _exists(path: str) -> bool:
    file, _ = Ar.SplitPackageRelativePathOuter(path) if Ar.IsPackageRelativePath(path) else (path, "")
    if _UDIM.search(file):
        return Path(file).parent.is_dir()
    return os.path.exists(file)
