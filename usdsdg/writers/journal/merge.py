"""Joining the parts of a dataset that several processes have made in one folder."""

from __future__ import annotations

import hashlib
import heapq
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from usdsdg.errors import DatasetError, warn_once
from usdsdg.stage.semantics.semantic_classes import BESIDE
from usdsdg.stores.whole_file import facts_of, write_whole
from usdsdg.writers.journal import journal, recipe
from usdsdg.writers.journal.facts import ASSETS, Facts, assets_of_two_contents, joined
from usdsdg.writers.journal.frames import FileFacts
from usdsdg.writers.journal.journal import NAME
from usdsdg.writers.journal.lines import FACTS, FRAME, SHARED, SPOOLS, is_count, parsed_record
from usdsdg.writers.journal.places.place import JOINED, LATEST, PARTS, Place
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.spool_hashes import AGGREGATES, SpoolHashes, check_whole

_SHARD = re.compile(r"\d+-of-(\d+)")
MAX_SHARDS = 100_000
_SHOWN = 8


def parts_of(folder: Path) -> list[Path]:
    """Return the folders of the parts of a dataset, in an order that does not depend on the file system."""
    return sorted(each.parent for each in (folder / PARTS).glob(f"*/{NAME}"))


def join(place: Place) -> int:
    """Join the journals and spools of the parts to those of one run; return the number of frames.

    The parts stay, as `JOINED`, until the caller has closed the journal: a process that died before is resumed.

    Raises:
        DatasetError: there are no parts, one is unfinished, or frames are missing or there twice.
        WriterError: a journal or a spool of a part was damaged.
    """
    folder = place.path
    parts = parts_of(folder)
    if not parts and (folder / JOINED).is_dir():
        return len(journal.read(folder / BESIDE / NAME).frames)
    if not parts:
        is_whole = (folder / BESIDE / NAME).is_file() and journal.read(folder / BESIDE / NAME).is_complete
        why = "it is whole already" if is_whole else f"there is no {PARTS}"
        raise DatasetError(f"{place.name} has no parts to be joined: {why}")
    _check_shards(place.name, {part.name for part in parts})
    _check_recipes(place, parts)
    contents = {part.name: journal.read(part / NAME) for part in parts}
    unfinished = [name for name, each in contents.items() if not each.is_complete]
    if unfinished:
        raise DatasetError(f"{place.name}: parts {', '.join(unfinished)} are unfinished; run them again with --resume")
    _check_frames(place.name, contents)
    for part in parts:
        check_whole(part / AGGREGATES, contents[part.name].spools)
    spools: dict[str, FileFacts] = {}
    for name in sorted({each.relative_to(part / AGGREGATES).as_posix() for part in parts for each in _spools(part)}):
        pieces = [part / AGGREGATES / name for part in parts if (part / AGGREGATES / name).is_file()]
        joined_spool = folder / BESIDE / AGGREGATES / name
        write_whole(joined_spool, _joined_spool(pieces))
        spools[name] = facts_of(joined_spool)
    facts = joined(each.facts for each in contents.values())
    if changed := assets_of_two_contents(facts.get(ASSETS, {})):
        warn_once(
            f"{place.name}: its parts were made with different content of {listed(changed)}, so that the dataset has "
            "frames of several versions of it; --overwrite makes all frames again."
        )
    classes = _joined_classes(parts)
    latest = _latest({part: contents[part.name].end for part in parts})
    if classes is not None:
        latest[recipe.CLASSES] = classes
    for name, data in latest.items():
        place.write(name, data)
    write_whole(folder / BESIDE / NAME, _joined_journal(parts, facts, spools, latest))
    shutil.rmtree(folder / JOINED, ignore_errors=True)
    os.replace(folder / PARTS, folder / JOINED)  # at once: parts of which some are gone could not be joined again
    return sum(len(each.frames) for each in contents.values())


def missing_shards(names: Iterable[str]) -> list[str]:
    """Return, as "i/n", the shards that parts with these names lack, also those after the last frame of the others."""
    there = set(names)
    counts = sorted({int(match[1]) for name in there if (match := _SHARD.fullmatch(name))})
    return [
        f"{each}/{count}"
        for count in counts
        for each in range(min(count, MAX_SHARDS))
        if f"{each}-of-{count}" not in there
    ]


def listed(names: list[str]) -> str:
    """Return the first ones of many names, with commas."""
    return ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


def of_missing_shards(missing: list[str]) -> str:
    """Return what to say of shards that are not there."""
    if len(missing) == 1:
        return f"shard {missing[0]} is missing; make it with --shard"
    return f"shards {listed(missing)} are missing; make them with --shard"


def _check_shards(where: str, names: set[str]) -> None:
    if missing := missing_shards(names):
        raise DatasetError(f"{where}: {of_missing_shards(missing)}")


def _check_recipes(place: Place, parts: list[Path]) -> None:
    """Check that all parts, and the folder that they are in, are of one recipe; those of earlier versions have none."""
    wanted = recipe.read(place.path, remedy=recipe.PUT_BACK) or {}
    for part in parts:
        try:
            own = json.loads((part / recipe.IDENTITY_FILE).read_bytes())
            if not isinstance(own, dict):
                raise ValueError("it is no recipe")
        except FileNotFoundError:
            continue
        except (ValueError, RecursionError, OSError) as error:
            raise DatasetError(
                f"{part / recipe.IDENTITY_FILE} cannot be read: {error}. Make this part again."
            ) from None
        if differing := [name for name in recipe.IDENTITY if own.get(name) != wanted.get(name)]:
            raise DatasetError(
                f"{place.name}: part {part.name} is of another recipe than {place.name}/{recipe.FILE}: "
                f"{', '.join(differing)} differ. Join only parts of one run."
            )


def _check_frames(where: str, contents: Mapping[str, journal.Contents]) -> None:
    owner: dict[int, str] = {}
    for name, each in contents.items():
        for number in sorted(each.frames):
            if number in owner:
                raise DatasetError(
                    f"{where}: frame {number} is in the parts {owner[number]} and {name}. Remove one of them, a folder "
                    f"in {where}/{PARTS}, and make the frames that are missing then; or begin again with --overwrite."
                )
            owner[number] = name
    # Writers with a trigger of their own are not due at every frame: a part that was to make one would have it.
    first = min((each.first for each in contents.values() if each.first is not None), default=0)
    portions = [portion for name in contents if (portion := Portion.of_name(name)) is not None]
    missing = [
        number
        for number in range(first, max(owner, default=-1) + 1)
        if number not in owner and not any(each.has(number) for each in portions)
    ]
    if missing:
        frames, them = ("frame", "it") if len(missing) == 1 else ("frames", "them")
        are = "is" if len(missing) == 1 else "are"
        raise DatasetError(
            f"{where}: {frames} {listed([*map(str, missing)])} {are} in no part; make {them} with --frames"
        )


def _spools(part: Path) -> Iterator[Path]:
    return SpoolHashes(part / AGGREGATES).files()


def _joined_classes(parts: list[Path]) -> bytes | None:
    """Return the class file with most classes, since tables grow from frame to frame; None: no part has one."""
    files = [part / recipe.CLASS_FILE for part in parts if (part / recipe.CLASS_FILE).is_file()]
    return max((file.read_bytes() for file in files), key=_count_of_classes, default=None)


def _latest(ends: Mapping[Path, int]) -> dict[str, bytes]:
    """Return the files of which each part has a version of its own, as the part with the last picture has them.

    They grow with the pictures, so that is the longest version: the part with the last frames may have no picture
    there, where render products were off. ends: by the folder of a part, the frame after its last one.
    """
    found: dict[str, bytes] = {}
    for part in sorted(ends, key=lambda each: ends[each]):
        for file in sorted((part / LATEST).rglob("*")):
            if file.is_file():
                name, data = file.relative_to(part / LATEST).as_posix(), file.read_bytes()
                if len(data) >= len(found.get(name, b"")):
                    found[name] = data
    return found


def _count_of_classes(table: bytes) -> int:
    try:
        return sum(len(each["classes"]) for each in json.loads(table)["tables"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return -1


def _joined_journal(
    parts: list[Path], facts: Facts, spools: Mapping[str, FileFacts], latest: Mapping[str, bytes]
) -> Iterator[bytes]:
    contents = [journal.read(part / NAME) for part in parts]
    shared = {name: facts for each in contents for name, facts in each.shared.items()}
    shared |= {name: (len(data), hashlib.sha256(data).hexdigest()) for name, data in latest.items()}
    frames = [(line for line in journal.lines(part / NAME) if FRAME in line) for part in parts]
    yield journal.encoded({SHARED: shared, FACTS: facts, SPOOLS: spools})
    yield from map(journal.encoded, heapq.merge(*frames, key=lambda line: line[FRAME]))


def _joined_spool(pieces: list[Path]) -> Iterator[bytes]:
    """Yield the lines that one process would have written: what is true of all frames only where it has changed."""
    kind = about = None
    for _, lines in heapq.merge(*map(_by_frame, pieces), key=lambda each: each[0]):
        for line in lines:
            content = json.loads(line)
            if "kind" in content:
                if kind is not None:
                    continue
                kind = line
            elif "about" in content:
                if about == line:
                    continue
                about = line
            yield line


def _by_frame(path: Path) -> Iterator[tuple[int, list[bytes]]]:
    """Yield the line of each frame's record with the lines before it that are of no frame, and those after the last."""
    lines: list[bytes] = []
    with open(path, "rb") as file:
        for line in file:
            lines.append(line)
            content = parsed_record(line)
            if content is None or (FRAME in content and not is_count(content[FRAME])):
                raise DatasetError(f"{path} is damaged; remove the part with --overwrite, and make it again")
            if FRAME in content:
                yield content[FRAME], lines
                lines = []
    if lines:
        yield sys.maxsize, lines
