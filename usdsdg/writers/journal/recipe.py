"""The recipe of a dataset, `.usdsdg/recipe.json`: everything that decides its bytes."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import write_whole

FILE = f"{BESIDE}/recipe.json"
GENERATE, RUN, SCRIPT = "generate", "run", "python"
# Facts that tell one recipe from another; the others follow from them.
IDENTITY = ("command", "source", "arguments", "seed", "classes", "versions", "device")
OUTPUT = "<output>"  # in arguments, in place of a path to the data
_PACKAGES = ("usdsdg", "usd-core", "warp-lang", "newton", "numpy")


@dataclass
class Recipe:
    """What a run is made of.

    Attributes:
        command: "generate" or "run" of the command line, or "python" for a script that Python runs.
        source: name of the configuration or script, and the SHA-256 of its content.
        arguments: overrides of a configuration, or arguments of a script, without output folders.
        seed: of the run; None: the configuration's.
        classes: those that were given for the dataset; None: none.
        versions: of the packages that decide what is rendered.
        device: "cpu" or "cuda"; "" until it is known.
        writers: their names and arguments, without output folders.
        assets: path below the assets root or name, SHA-256, and source and license where the layer tells.
        settings: that differ from their defaults.
    """

    command: str
    source: dict[str, str]
    arguments: list[str] = field(default_factory=list)
    seed: int | None = None
    classes: Any = None
    versions: dict[str, str] = field(default_factory=lambda: installed())
    device: str = ""
    writers: list[dict[str, Any]] = field(default_factory=list)
    assets: list[dict[str, Any]] = field(default_factory=list)

    def of(self, folder: Path) -> Recipe:
        """Return the recipe of the data in a folder, which is the same wherever the folder is."""
        return replace(self, arguments=[_placeless(each, folder) for each in self.arguments])

    def differences(self, other: Mapping[str, Any]) -> list[str]:
        """Return what differs from the recipe in a file, one line for each fact."""
        mine, found = self.values(), []
        for name in IDENTITY:
            theirs, own = other.get(name), mine[name]
            if isinstance(theirs, dict) and isinstance(own, dict):
                pairs = {f"{name}.{key}": (theirs.get(key), own.get(key)) for key in {**theirs, **own}}
            else:
                pairs = {name: (theirs, own)}
            found += [f"{key}: {_short(a)} there, {_short(b)} now" for key, (a, b) in pairs.items() if a != b]
        return found

    def values(self) -> dict[str, Any]:
        """Return the recipe as it is written to a file."""
        return {"format": 1, **vars(self)}

    def write(self, folder: Path) -> str:
        """Write it beside the data in a folder, and return the SHA-256 of the file.

        Raises:
            OutputNotWritable: it cannot be written.
        """
        data = json.dumps(self.values(), indent=1, default=str).encode() + b"\n"
        write_whole(folder / FILE, data)
        return hashlib.sha256(data).hexdigest()


def read(folder: Path) -> dict[str, Any] | None:
    """Return the recipe in a folder; None if there is none.

    Raises:
        WriterError: the file is damaged.
    """
    try:
        values = json.loads((folder / FILE).read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise WriterError(f"{folder / FILE} cannot be read: {error}. Remove that run with --overwrite.") from None
    if not isinstance(values, dict):
        raise WriterError(f"{folder / FILE} is no recipe. Remove that run with --overwrite.")
    return values


def source_of(file: Path) -> dict[str, str]:
    """Return the name of a file and the SHA-256 of its content."""
    return {"name": file.name, "sha256": hashlib.sha256(file.read_bytes()).hexdigest()}


def installed() -> dict[str, str]:
    """Return the versions of the packages that decide what is rendered."""
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "?"
    return found


def _placeless(argument: str, folder: Path) -> str:
    """Return an argument without the path of the output folder, or of one that it is in."""
    name, equals, value = argument.rpartition("=")
    place = Path(value).expanduser().absolute()
    leads_there = bool(value) and (folder == place or folder.is_relative_to(place)) and place != Path(place.anchor)
    return f"{name}{equals}{OUTPUT}" if leads_there else argument


def _short(value: Any) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
