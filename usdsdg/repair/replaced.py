"""Damaged files of a dataset that are replaced by files with the bytes that the run has written."""

from __future__ import annotations

import stat
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from usdsdg.errors import OutputNotWritable
from usdsdg.repair.damage import Damage
from usdsdg.stores.paths import path_below
from usdsdg.stores.whole_file import facts_of, write_whole
from usdsdg.verify.integrity.listing import ListedFile
from usdsdg.writers.formats.rerun import rrd_content

_AT_A_TIME = 1 << 20  # bytes in memory
NOT_MADE, OTHER = "was not made again", "is made with other bytes than the run wrote"
RECORDING = "is a recording, whose metadata have another order each time it is made"


@dataclass
class Repair:
    """What has come of the damaged files of a dataset.

    Attributes:
        keep: makes files durable that were replaced in the folder.
        repaired: those that have the bytes again that the run wrote, by their paths.
        left: why each of the others is as it was.
    """

    damage: Damage
    keep: Callable[[Sequence[str]], None]
    repaired: list[str] = field(default_factory=list)
    left: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.left = dict.fromkeys(self.damage.files, NOT_MADE)
        self._synced = 0  # of those that are repaired

    @property
    def shared(self) -> list[str]:
        """Files about all frames that are left though nothing but their content is to blame.

        None where files of single frames are made with other bytes: more frames would be so, too.
        """
        files = self.damage.files
        left = [name for name, why in self.left.items() if why in (NOT_MADE, OTHER)]
        if any(files[name].frame.isdigit() and self.left[name] == OTHER for name in left):
            return []
        return [name for name in left if not files[name].frame.isdigit()]

    def take_file(self, name: str, made: Iterable[Path]) -> None:
        """As `take`, of one file, which files of other names may equal."""
        self._take(name, list(made))
        self._sync()

    def take(self, made: Iterable[Path]) -> None:
        """Replace the files that are left by those that are equal to what the journal lists.

        made: folders with files that were made again. Each file is replaced at once, or stays as it is.
        """
        folders = list(made)
        for name in list(self.left):
            self._take(name, [each / name for each in folders])
        self._sync()

    def explain(self, names: Iterable[str], why: str) -> None:
        """Tell why those of some files that were not made could not be."""
        for name in names if why else ():
            if self.left.get(name) == NOT_MADE:
                self.left[name] = f"{NOT_MADE}: {why}"

    def _sync(self) -> None:
        """Wait until what was repaired is on the disk, in one call for all files."""
        new = self.repaired[self._synced :]
        if new:
            self.keep(new)
            self._synced = len(self.repaired)

    def _take(self, name: str, made: list[Path]) -> None:
        why = self._taken(name, made) if name in self.left else None
        if why == "":
            del self.left[name]
            self.repaired.append(name)
        elif why is not None:
            self.left[name] = why

    def _taken(self, name: str, made: list[Path]) -> str | None:
        """Return why a file is not replaced, "" if it is, None where it was not made."""
        listed = self.damage.listing.files[name]
        there = [each for each in made if each.is_file()]
        equal = next((each for each in there if _has(each, listed)), None)
        if equal is None:
            return (RECORDING if name.endswith(rrd_content.SUFFIX) else OTHER) if there else None
        return replace(self.damage.folder, name, equal)


def replace(folder: Path, name: str, made: Path) -> str:
    """Put a copy of a file in the place of one of a dataset, whatever is there, at once; return why not, or ""."""
    try:
        file = path_below(folder, name)
        if _is_folder(file):
            return "has a folder in its place; remove that"
        write_whole(file, _chunks(made))
    except OutputNotWritable as error:
        # The remedy of the error is that of a run, which may choose its output_dir.
        return (
            f"cannot be replaced: {error.cause}; repair again once that is put right"
            if error.cause
            else (f"cannot be replaced: {error}")
        )
    return ""


def _has(file: Path, listed: ListedFile) -> bool:
    return file.stat().st_size == listed.size and facts_of(file) == (listed.size, listed.sha256)


def _is_folder(file: Path) -> bool:
    try:
        return stat.S_ISDIR(file.lstat().st_mode)
    except OSError:
        return False


def _chunks(file: Path) -> Iterator[bytes]:
    with open(file, "rb") as opened:
        while data := opened.read(_AT_A_TIME):
            yield data
