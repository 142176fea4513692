"""A folder of meshes as a job takes it: files by class, their sizes and units."""

from __future__ import annotations

import difflib
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Gf, Usd

from usdsdg.arguments.asset_folders import USD_SUFFIXES, usd_files
from usdsdg.errors import AssetNotFound, ConfigError
from usdsdg.meshes.cache import converted
from usdsdg.meshes.conversion import Options
from usdsdg.meshes.placement import UNITS, is_plausible, likely_unit
from usdsdg.stage import assets
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.geometry.own_box import own_box
from usdsdg.stage.poses.transforms import local_to_world, meters_per_unit

AUTO = "auto"
# With what the meters of all files of a folder may be multiplied: they are right, or those of all are millimeters.
_COMMON = (1.0, UNITS["mm"])
_NUMBER = re.compile(r"^\d+[_-]+(?=.*[A-Za-z])")


@dataclass(frozen=True)
class MeshAsset:
    """An object that is put on the stage. Lengths are in meters, axes those of its file."""

    label: str
    file: str  # a USD file
    scale: float  # from the file's units to meters
    low: tuple[float, float, float]  # corners of its bounds
    high: tuple[float, float, float]

    @property
    def center(self) -> np.ndarray:
        """Center of its bounds (3,)."""
        return (np.array(self.low) + self.high) / 2.0

    @property
    def radius(self) -> float:
        """Of the sphere around its bounds."""
        return float(np.linalg.norm(np.array(self.high) - self.low)) / 2.0


def files_by_label(folder: str, labels: Mapping[str, str] | None = None) -> dict[str, list[str]]:
    """Return the USD and mesh files of a folder by class, both sorted.

    A file's class is its name, without a number in front where the names still differ then; of files in a subfolder,
    the subfolder's name. `labels` gives classes by these names; "" leaves an object out.

    Raises:
        ConfigError: there is no such folder, no mesh in it, or `labels` has a name that it has not.
    """
    try:
        root = Path(assets.resolve(folder))
        found = usd_files(folder, recursive=True)
    except AssetNotFound as error:
        raise ConfigError(str(error)) from None
    if not found:
        like_files = [each.name for each in sorted(root.rglob("*")) if each.suffix.lower() in USD_SUFFIXES]
        hint = f" ({like_files[0]} is named like one, but it is a folder)" if like_files else ""
        raise ConfigError(f"{folder} has no meshes{hint}; expected files {', '.join(USD_SUFFIXES)}")
    named = _named(root, found)
    renamed = dict(labels or {})
    if unknown := [name for name in renamed if name not in named]:
        near = [close for name in unknown for close in difflib.get_close_matches(name, named, n=1)]
        hint = f"; did you mean {', '.join(near)}?" if near else f"; {folder} has {', '.join(list(named)[:20])}"
        raise ConfigError(f"labels names {', '.join(unknown)}, which {folder} has not{hint}")
    by_label: dict[str, list[str]] = {}
    for name, files in named.items():
        label = renamed.get(name, name).strip().lower()
        if label:
            by_label.setdefault(label, []).extend(files)
    if not by_label:
        raise ConfigError(f"labels leaves out every mesh of {folder}")
    return {label: sorted(by_label[label]) for label in sorted(by_label)}


def _named(root: Path, files: Sequence[str]) -> dict[str, list[str]]:
    """Return files by name, one file of each name in a folder: the same object is often there in several forms."""
    chosen: dict[tuple[str, str], str] = {}
    for file in sorted(files, key=lambda each: (USD_SUFFIXES.index(Path(each).suffix.lower()), each)):
        path = Path(file).relative_to(root)
        chosen.setdefault((str(path.parent), path.stem), file)
    dropped = sorted(set(files) - set(chosen.values()))
    if dropped:
        print(f"meshes: of several forms of one object the first is taken, without {_some(dropped)}", file=sys.stderr)
    named: dict[str, list[str]] = {}
    for (folder, stem), file in chosen.items():
        named.setdefault(stem if folder == "." else Path(folder).parts[0], []).append(file)
    short = {name: _NUMBER.sub("", name) for name in named}
    repeated = Counter(short.values())
    return {name if repeated[short[name]] > 1 else short[name]: named[name] for name in sorted(named)}


def read_assets(by_label: Mapping[str, Sequence[str]], unit: str) -> list[MeshAsset]:
    """Convert and measure files; say which unit they are read in where that is not what they say.

    Args:
        unit: a key of UNITS, or "auto": the unit that each file says, unless objects would have odd sizes then.

    Raises:
        AssetError: a file cannot be opened, or holds nothing that is drawn.
        ConfigError: no file holds geometry.
    """
    measured = [(label, file, *_measured(_as_usd(file))) for label, files in by_label.items() for file in files]
    factors = _factors([(own, float(np.max(high - low))) for _, _, _, own, low, high in measured], unit)
    found = []
    for (label, file, usd, own, low, high), factor in zip(measured, factors):
        scale = own * factor
        size = " x ".join(f"{each:.3g}" for each in (high - low) * scale)
        if factor != 1.0:
            name = next((name for name, meters in UNITS.items() if meters == factor), f"{factor:g} m")
            print(f"meshes: {Path(file).name} is read in {name}: {size} m (mesh_unit: {unit})", file=sys.stderr)
        found.append(MeshAsset(label, usd, scale, _triple(low * scale), _triple(high * scale)))
    return found


def _factors(sizes: Sequence[tuple[float, float]], unit: str) -> list[float]:
    """Return what each file's meters are multiplied with; `sizes` are its meters per unit and its size in units."""
    if unit != AUTO:
        return [UNITS[unit] / own for own, _ in sizes]
    meters = [own * size for own, size in sizes]
    # One unit for all is likelier than one for each: a washer of 3 mm is plausible as one of 3 m.
    together = next((factor for factor in _COMMON if all(is_plausible(size * factor) for size in meters)), None)
    return [together or UNITS[likely_unit(size)] for size in meters]


def _as_usd(file: str) -> str:
    """Return the USD file of a mesh; with the axes of the mesh's own file, to which poses then refer."""
    return converted(file, Options(up_axis="Z", source_up_axis="Z", names_size=False)) if assets.is_mesh(file) else file


def _measured(file: str) -> tuple[str, float, np.ndarray, np.ndarray]:
    """Return the USD file, its meters per unit, and the bounds of its default prim in units."""
    stage = Usd.Stage.Open(assets.open_layer(file))
    root = stage.GetDefaultPrim()
    if not root:
        raise ConfigError(f"{file} has no default prim, so that nothing can refer to it; set one")
    own = own_box(root, DRAWN_PURPOSES)
    bounds = Gf.BBox3d(own, local_to_world(root)).ComputeAlignedRange()
    low, high = np.array(bounds.GetMin()), np.array(bounds.GetMax())
    if bounds.IsEmpty() or not np.max(high - low) > 0.0:
        raise ConfigError(f"{file} holds no geometry that is drawn")
    return file, meters_per_unit(stage), low, high


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def _some(files: Sequence[str]) -> str:
    names = [Path(file).name for file in files]
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
