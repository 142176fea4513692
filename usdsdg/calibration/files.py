"""Files with calibrated cameras: OpenCV's FileStorage, ROS' camera_info, Kalibr's camchain, and rigs as lists."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml

from usdsdg.arguments.yaml_bounds import TooLarge, check_yaml, read_small
from usdsdg.arguments.yaml_numbers import NumbersLoader
from usdsdg.calibration import forms
from usdsdg.calibration.calibration import Calibration
from usdsdg.calibration.poses import chained, placed
from usdsdg.calibration.rig import Mount, Rig
from usdsdg.errors import ConfigError
from usdsdg.stage.assets.opened import note_opened

_FORMS = (
    "expected OpenCV's FileStorage or ROS' camera_info (camera_matrix, distortion_coefficients, image_width, "
    "image_height), Kalibr's camchain (cam0 with intrinsics, distortion_coeffs, resolution), or a list called rig"
)


class _Loader(NumbersLoader):
    """A loader that also takes the matrices of OpenCV."""


def _matrix(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", _matrix)


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Return the camera of a file; `camchain.yaml#cam1` is one of several.

    Raises:
        ConfigError: the file cannot be read, has several cameras and none is named, or holds no calibration that a lens
            here can express.
    """
    file, _, wanted = str(path).partition("#")
    mounts = read_rig(file).mounts
    names = [mount.name for mount in mounts]
    if not wanted and len(mounts) > 1:
        raise ConfigError(
            f"{file} has {len(mounts)} cameras; choose one: {', '.join(f'{file}#{each}' for each in names)}"
        )
    if wanted and wanted not in names:
        raise ConfigError(f"{file} has no camera {wanted!r}; it has {', '.join(names)}")
    return mounts[names.index(wanted) if wanted else 0].calibration


def read_rig(path: str | os.PathLike[str]) -> Rig:
    """Return the cameras of a file with their places; a file of one camera is a rig of one.

    Raises:
        ConfigError: as for `read_calibration`, or a place is no rigid pose.
    """
    file = Path(os.path.expanduser(path))
    values = _values(file)
    if "rig" in values:
        return _listed(file, values["rig"])
    if chain := forms.cameras_of_chain(values):
        mounts = [forms.kalibr(each, f"{file}: {name}") for name, each in chain.items()]
        return Rig(tuple(map(Mount, chain, mounts, chained(chain, str(file)))))
    reader: Callable[..., Calibration] | None = forms.reader_of(values)
    if reader is None:
        raise ConfigError(f"{file} is no calibration of a camera: it has {_keys(values)}; {_FORMS}")
    name = str(values.get("camera_name") or "camera")
    return Rig((Mount(name, reader(values, str(file)), placed({}, name)),))


def _listed(file: Path, entries: Any) -> Rig:
    """Return the rig of a list of mappings with name, calibration, and translation and quaternion or a matrix."""
    if not isinstance(entries, list) or not entries or not all(isinstance(each, Mapping) for each in entries):
        raise ConfigError(f"{file}: rig is {entries!r}; expected a list of mappings with name, calibration and a pose")
    mounts, names = [], set()
    for index, entry in enumerate(entries):
        name = str(entry.get("name") or f"cam{index}")
        where = f"{file}: rig[{index}] ({name})"
        if unknown := sorted(set(map(str, entry)) - {"name", "calibration", *forms.POSE_KEYS}):
            raise ConfigError(
                f"{where}: unknown key {', '.join(unknown)}; expected name, calibration, {', '.join(forms.POSE_KEYS)}"
            )
        if name in names:
            raise ConfigError(f"{where}: two cameras have this name")
        names.add(name)
        mounts.append(Mount(name, _calibration_of(file, entry.get("calibration"), where), placed(entry, where)))
    return Rig(tuple(mounts))


def _calibration_of(file: Path, given: Any, where: str) -> Calibration:
    if isinstance(given, str):
        return read_calibration(file.parent / given)
    reader = forms.reader_of(given) if isinstance(given, Mapping) else None
    if reader is None:
        raise ConfigError(f"{where}: calibration is {given!r}; expected the path of a file, or the keys of one")
    return reader(given, where)


def _values(file: Path) -> dict[str, Any]:
    try:
        text = read_small(file)
        note_opened(os.path.abspath(file))
    except TooLarge:
        raise
    except (OSError, ValueError) as error:  # the latter of its text, or of a null character in the path
        raise ConfigError(f"{file}: the calibration cannot be read: {error}") from error
    if text.lstrip().startswith("<?xml"):
        raise ConfigError(f"{file} is XML; write OpenCV's FileStorage to a file that ends in .yml instead")
    # OpenCV's first line, %YAML:1.0, is no directive of YAML.
    text = "".join("\n" if line.startswith("%YAML") else line for line in text.splitlines(keepends=True))
    try:
        check_yaml(text, str(file))
        values = next(iter(yaml.load_all(text, Loader=_Loader)), None)
    except TooLarge:
        raise
    except (yaml.YAMLError, RecursionError) as error:
        raise ConfigError(f"{file}: not valid YAML: {error}") from None
    if not isinstance(values, dict):
        raise ConfigError(f"{file} is no calibration of a camera; {_FORMS}")
    return {str(key): value for key, value in values.items()}


def _keys(values: Mapping[str, Any]) -> str:
    return ", ".join(list(values)[:8]) or "no keys"
