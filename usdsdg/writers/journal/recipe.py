"""The recipe of a dataset, `.usdsdg/recipe.json`: everything that decides its bytes."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from usdsdg.errors import AssetUnreadable, DatasetError, WriterError
from usdsdg.stage.assets.anchors import portable_below_root
from usdsdg.stage.assets.file_checks import check_regular
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stage.semantics.semantic_classes import FILE as CLASS_FILE
from usdsdg.stores.addresses import is_url
from usdsdg.stores.whole_file import write_whole
from usdsdg.writers.journal.facts import ASSETS, SETTINGS, WRITERS, Facts
from usdsdg.writers.journal.lines import is_count

FILE, FORMAT = f"{BESIDE}/recipe.json", 1
SOURCE = f"{BESIDE}/source"  # folder of a copy of the configuration or script
CLASSES = f"{BESIDE}/{CLASS_FILE}"
SEED_SETTING = "/omni/replicator/globalSeed"
CLASSES_SETTING = "/usdsdg/labels/semanticClasses"
_TEXTS, _LARGEST = (".py", ".yaml", ".yml", ".json"), 1 << 20
PHYSICS_DEVICE = "physics_device"  # of the options: the kind of the device that bodies are simulated on
GENERATE, RUN, SCRIPT = "generate", "run", "python"
# Facts that tell one recipe from another; the others follow from them.
IDENTITY = ("command", "source", "arguments", "options", "seed", "classes", "versions", "device")
IDENTITY_FILE = "recipe.json"  # of a part
# What may be done about a damaged recipe, by a run into its folder, and by what only reads the dataset.
REMOVED = "Remove that run with --overwrite."
PUT_BACK = "Put a copy of it back, or make the dataset anew with --overwrite."
UNREADABLE = "Give this user the right to read it, or work on a copy of the dataset."
OUTPUT = "<output>"  # in arguments, in place of a path to the data
RECORDS = 3  # version of the format of frame records, usdsdg.record.frame_record.VERSION
_PACKAGES = ("usdsdg", "usd-core", "warp-lang", "newton", "numpy")


@dataclass
class Recipe:
    """What a run is made of.

    Attributes:
        command: "generate" or "run" of the command line, or "python" for a script that Python runs.
        source: name of the configuration or script, and the SHA-256 of its content.
        arguments: overrides of a configuration, or arguments of a script, without output folders and the assets root.
        options: of the command that decide what a script does, apart from their defaults.
        seed: of the run; None: a saved stage's own, or not known.
        classes: those that were given for the dataset; None: none.
        versions: of the packages that decide what is rendered, and of the format of frame records.
        device: that pictures are made on, "cpu" or "cuda"; "" until it is known.
        frames: how many there are; None until the run has ended.
        writers: of the folder, by their keys: type and arguments, without output folders.
        assets: name below the assets root, or of the file and its path, size and SHA-256, and source and license where
            the layer tells; also the modules of a script that are in its folder.
        settings: that differ from their defaults at the first frame, and the global seed.
        class_table: the names of the classes of each label filter, in the order of their ids.
        copy: how many writers of the run were given the same place before, where each has a new one with a number.
    """

    command: str
    source: dict[str, str]
    arguments: list[str] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)
    seed: int | None = None
    classes: Any = None
    versions: dict[str, str] = field(default_factory=lambda: installed())
    device: str = ""
    frames: int | None = None
    writers: dict[str, Any] = field(default_factory=dict)
    assets: list[dict[str, Any]] = field(default_factory=list)
    settings: dict[str, Any] = field(default_factory=dict)
    class_table: dict[str, list[str]] = field(default_factory=dict)
    copy: int = 0

    @classmethod
    def of_values(cls, values: Mapping[str, Any], folder: Path) -> Recipe:
        """Return the recipe that a file has, as `read` returns it.

        Raises:
            DatasetError: it lacks what a recipe has, or is of a later version.
        """
        known = {each.name for each in fields(cls)}
        unknown = values.keys() - known - {"format"}
        if values.get("format") != FORMAT or unknown:
            raise DatasetError(f"{folder / FILE} is not a recipe that this version of usdsdg reads")
        wrong = [name for name, is_right in _RIGHT.items() if name in values and not is_right(values[name])]
        if missing := [name for name in ("command", "source") if name not in values]:
            wrong += missing
        if wrong:
            raise DatasetError(f"{folder / FILE} is damaged: it has no sound {', '.join(wrong)}")
        return cls(**{name: value for name, value in values.items() if name in known})

    def of(self, place: str, copy: int = 0) -> Recipe:
        """Return the recipe of the data in a folder or at a URL, which is the same wherever that is."""
        arguments = [portable_below_root(_placeless(each, place)) for each in self.arguments]
        return replace(self, arguments=arguments, copy=copy)

    def completed(
        self, classes: bytes | None, frames: int, facts: Facts, there: Mapping[str, Any] = MappingProxyType({})
    ) -> Recipe:
        """Return the recipe with what only the run itself could tell.

        classes: the class table beside the data, as in its file. facts: of the journal. there: the recipe in the file,
        of which the names of the classes are kept where there is no table.
        """
        return replace(
            self,
            frames=frames,
            writers=facts.get(WRITERS, {}),
            assets=list(facts.get(ASSETS, {}).values()),
            settings=facts.get(SETTINGS, {}),
            class_table=_class_names(classes) if classes is not None else there.get("class_table", {}),
        )

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
        values = {"format": FORMAT, **vars(self)}
        return values if self.copy else {name: value for name, value in values.items() if name != "copy"}

    def write_identity(self, folder: Path) -> None:
        """Write what tells it from other recipes into the folder of a part, which may be copied beside other parts.

        Raises:
            OutputNotWritable: it cannot be written.
        """
        mine = self.values()
        write_whole(folder / IDENTITY_FILE, json.dumps({name: mine[name] for name in IDENTITY}, default=str).encode())

    def write(self, folder: Path) -> str:
        """Write it beside the data in a folder, and return the SHA-256 of the file.

        Raises:
            OutputNotWritable: it cannot be written.
        """
        data = json.dumps(self.values(), indent=1, default=str).encode() + b"\n"
        write_whole(folder / FILE, data)
        return hashlib.sha256(data).hexdigest()


def _are_texts(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(each, str) for each in value.values())


def _is_source(value: Any) -> bool:
    """Whether a value names a file, without a folder, and its hash."""
    name = value.get("name") if _are_texts(value) else None
    return bool(name) and name not in (".", "..") and not {"/", "\\", "\0"} & set(name) and "sha256" in value


# What is read of a recipe, with what it may be.
_RIGHT: dict[str, Callable[[Any], bool]] = {
    "command": lambda value: value in (GENERATE, RUN, SCRIPT),
    "source": _is_source,
    "arguments": lambda value: isinstance(value, list) and all(isinstance(each, str) for each in value),
    "options": lambda value: isinstance(value, dict),
    "seed": lambda value: value is None or is_count(value),
    "versions": _are_texts,
    "device": lambda value: isinstance(value, str),
    "settings": lambda value: isinstance(value, dict),
    "copy": is_count,
}


def _class_names(table: bytes | None) -> dict[str, list[str]]:
    """Return the names of the classes by label filter, from the class table beside the data; empty without one."""
    try:
        tables = json.loads(table or b"{}")["tables"]
        return {each["filter"]: [row["name"] for row in each["classes"]] for each in tables}
    except (ValueError, KeyError, TypeError):
        return {}


@dataclass(frozen=True)
class Source:
    """A script or configuration as it was when the run began, which its file may be no more at the first frame."""

    file: Path
    content: bytes | None  # None: it is no text, or too large to be kept beside the data

    @classmethod
    def read(cls, file: Path) -> Source:
        """Read a file. The script may leave the working folder, so that its path becomes absolute."""
        is_kept = file.suffix.lower() in _TEXTS and file.stat().st_size <= _LARGEST
        return cls(file.absolute(), file.read_bytes() if is_kept else None)

    def facts(self) -> dict[str, str]:
        """Return its name and the SHA-256 of its content."""
        if self.content is None:
            return source_of(self.file)
        return {"name": self.file.name, "sha256": hashlib.sha256(self.content).hexdigest()}

    def keep(self, folder: Path) -> str | None:
        """Keep a copy beside the data in a folder; return its path there, None where its content is not known.

        Raises:
            OutputNotWritable: it cannot be written.
        """
        if self.content is None:
            return None
        write_whole(folder / SOURCE / self.file.name, self.content)
        return f"{SOURCE}/{self.file.name}"


def read(folder: Path, *, remedy: str = REMOVED) -> dict[str, Any] | None:
    """Return the recipe in a folder; None if there is none.

    remedy: of a damaged one, for errors.

    Raises:
        WriterError: the file is damaged, or the system does not let it be read.
    """
    try:
        check_regular(str(folder / FILE))  # a pipe may never end
        data = (folder / FILE).read_bytes()
    except FileNotFoundError:
        return None
    except AssetUnreadable as error:
        raise WriterError(f"{error}. {remedy}") from None
    except IsADirectoryError:
        raise WriterError(f"{folder / FILE} is a folder. {remedy}") from None
    except OSError as error:
        reason = "a file is where a folder should be" if isinstance(error, NotADirectoryError) else error.strerror
        else_where = "Choose another output_dir, or make this one a folder that can be read and written."
        if remedy == PUT_BACK:  # of a command that writes to no folder of the user's choice
            else_where = UNREADABLE
        raise WriterError(f"{folder / FILE} cannot be read: {reason}. {else_where}") from None
    return parsed(data, str(folder), remedy=remedy)


def parsed(data: bytes | None, where: str, *, remedy: str = REMOVED) -> dict[str, Any] | None:
    """Return the recipe that a file has, None for None; `where` is what it is of. Raises as `read`."""
    if data is None:
        return None
    try:
        values = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise WriterError(f"{where}/{FILE} cannot be read: {error}. {remedy}") from None
    if not isinstance(values, dict):
        raise WriterError(f"{where}/{FILE} is no recipe. {remedy}")
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
    return found | {"frame records": str(RECORDS)}


def _placeless(argument: str, where: str) -> str:
    """Return an argument without the path or URL of the output folder or of one that it is in; these may have a =."""
    pieces = argument.split("=")
    for count in range(len(pieces)):
        if _leads_to(where, "=".join(pieces[count:])):
            return "=".join([*pieces[:count], OUTPUT])
    return argument


def _leads_to(where: str, value: str) -> bool:
    """Return whether a value is the path or URL of an output folder, or of one that it is in."""
    if is_url(where):
        top = value.rstrip("/")
        return is_url(value) and (where == top or where.startswith(f"{top}/"))
    folder = Path(where)
    place = Path(os.path.expanduser(value)).absolute()
    return bool(value) and (folder == place or folder.is_relative_to(place)) and place != Path(place.anchor)


def _short(value: Any) -> str:
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
