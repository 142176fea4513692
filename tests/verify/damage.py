"""Kinds of damage to the files of a dataset that has a journal, each with the files that `usdsdg verify` must name.

A kind is a function of the dataset's folder and a random generator; it returns the paths of the files, below the
folder, that must be named. No other file may be.
"""

import hashlib
import json
import os
import random
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path

JOURNAL, RECIPE = ".usdsdg/journal.jsonl", ".usdsdg/recipe.json"
Damage = Callable[[Path, random.Random], set[str]]
KINDS: dict[str, Damage] = {}
# What is no damage.
HARMLESS: dict[str, Damage] = {}


def kind(function: Damage) -> Damage:
    """Add a kind of damage."""
    KINDS[function.__name__] = function
    return function


def harmless(function: Damage) -> Damage:
    """Add what is no damage."""
    HARMLESS[function.__name__] = function
    return function


def files(folder: Path, pattern: str) -> list[str]:
    """Return the paths of files that match a pattern, in order."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.glob(pattern) if path.is_file())


def rewrite(path: Path, data: bytes) -> None:
    """Write a file anew, so that others that are hard links to the old one keep their bytes."""
    path.unlink()
    path.write_bytes(data)


def _edit(pattern: str, edit: Callable[[bytes, random.Random], bytes]) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        name = draw.choice(files(folder, pattern))
        data = (folder / name).read_bytes()
        changed = edit(data, draw)
        assert changed != data
        rewrite(folder / name, changed)
        return {name}

    return damage


def _flipped(data: bytes, place: int, draw: random.Random) -> bytes:
    return data[:place] + bytes([data[place] ^ (1 << draw.randrange(8))]) + data[place + 1 :]


def _journal(edit: Callable[[list[bytes], random.Random], list[bytes]], *named: str) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        path = folder / JOURNAL
        rewrite(path, b"".join(edit(path.read_bytes().splitlines(keepends=True), draw)))
        return set(named or (JOURNAL,))

    return damage


_IMAGES, _JSON, _RECORDS = "*rgb*.png", "*prim_paths*.json", ".usdsdg/frames/*.npz"
KINDS |= {
    "a flipped bit in an image": _edit(_IMAGES, lambda data, draw: _flipped(data, draw.randrange(len(data)), draw)),
    "a flipped bit in the first byte": _edit(_IMAGES, lambda data, draw: _flipped(data, 0, draw)),
    "a flipped bit in the last byte": _edit(_IMAGES, lambda data, draw: _flipped(data, len(data) - 1, draw)),
    "a flipped bit in an array": _edit("*.npy", lambda data, draw: _flipped(data, draw.randrange(len(data)), draw)),
    "a flipped bit in a record": _edit(_RECORDS, lambda data, draw: _flipped(data, draw.randrange(len(data)), draw)),
    "half an image": _edit(_IMAGES, lambda data, draw: data[: len(data) // 2]),
    "an image without its last byte": _edit(_IMAGES, lambda data, draw: data[:-1]),
    "an empty image": _edit(_IMAGES, lambda data, draw: b""),
    "a byte too much": _edit(_IMAGES, lambda data, draw: data + b"\0"),
    "zeros in a block": _edit(_IMAGES, lambda data, draw: data[:60] + bytes(40) + data[100:]),
    "an image of zeros": _edit(_IMAGES, lambda data, draw: bytes(len(data))),
    "a truncated JSON file": _edit(_JSON, lambda data, draw: data[: draw.randrange(1, len(data))]),
    "an empty table in JSON": _edit(_JSON, lambda data, draw: b"{}"),
    "JSON written in another form": _edit(_JSON, lambda data, draw: json.dumps(json.loads(data), indent=7).encode()),
    "line ends of another system": _edit("*.json", lambda data, draw: data.replace(b"{", b"{\r\n")),
    "a changed metadata.txt": _edit("metadata.txt", lambda data, draw: data.replace(b"version", b"Version")),
    "a changed class table": _edit(".usdsdg/classes.json", lambda data, draw: data.replace(b'"id": 2', b'"id": 3')),
    "a changed stage": _edit(".usdsdg/stages/*", lambda data, draw: _flipped(data, len(data) // 2, draw)),
    "a recipe cut off": _edit(RECIPE, lambda data, draw: data[:-20]),
    "a recipe with another seed": _edit(RECIPE, lambda data, draw: data.replace(b'"seed": 5', b'"seed": 6')),
    "a recipe that is no table": _edit(RECIPE, lambda data, draw: b"[1, 2]"),
    "a journal without its closing line": _journal(lambda lines, draw: lines[:-1]),
    "a journal that ends in a line": _journal(lambda lines, draw: [*lines[:-1], lines[-1][:30]]),
    "a journal with a doubled line": _journal(lambda lines, draw: [*lines[:2], *lines[1:]]),
    "a journal with two lines exchanged": _journal(lambda lines, draw: [lines[0], lines[2], lines[1], *lines[3:]]),
    "a journal without one line": _journal(lambda lines, draw: [*lines[:2], *lines[3:]]),
    "a journal with a garbled line": _journal(lambda lines, draw: [lines[0], b"\xff\0" + lines[1][2:], *lines[2:]]),
    "a journal that ends in zeros": _journal(lambda lines, draw: [*lines[:-1], bytes(len(lines[-1]))]),
    "a journal with line ends of another system": _journal(lambda lines, draw: [e[:-1] + b"\r\n" for e in lines]),
    "an empty journal": _journal(lambda lines, draw: []),
    "a line after the closing one": _journal(lambda lines, draw: [*lines, lines[1]]),
}


@kind
def a_wrong_hash_in_the_journal(folder: Path, draw: random.Random) -> set[str]:
    path = folder / JOURNAL
    shared, first, *rest = path.read_bytes().splitlines(keepends=True)
    line = json.loads(first)
    name, facts = next(iter(line["files"].items()))
    wrong = facts[1].translate(str.maketrans("0123456789abcdef", "123456789abcdef0"))
    rewrite(path, shared + first.replace(facts[1].encode(), wrong.encode()) + b"".join(rest))
    return {JOURNAL, name}


@kind
def another_name_in_the_journal(folder: Path, draw: random.Random) -> set[str]:
    path, name = folder / JOURNAL, draw.choice(files(folder, _IMAGES))
    rewrite(path, path.read_bytes().replace(name.encode(), b"X" + name.encode()[1:]))
    return {JOURNAL, name, "X" + name[1:]}


def _remove(*patterns: str) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        names = {draw.choice(files(folder, pattern)) for pattern in patterns}
        for name in names:
            (folder / name).unlink()
        return names

    return damage


KINDS |= {
    "a missing image": _remove(_IMAGES),
    "a missing JSON file": _remove(_JSON),
    "a missing record": _remove(_RECORDS),
    "a missing metadata.txt": _remove("metadata.txt"),
    "a missing stage": _remove(".usdsdg/stages/*"),
    "a missing class table": _remove(".usdsdg/classes.json"),
    "a missing recipe": _remove(RECIPE),
    "a missing journal": _remove(JOURNAL),
}


@kind
def all_files_of_a_frame_missing(folder: Path, draw: random.Random) -> set[str]:
    line = json.loads(draw.choice((folder / JOURNAL).read_text().splitlines()[:-1]))
    for name in line["files"]:
        (folder / name).unlink()
    return set(line["files"])


def _put(name: str, data: bytes = b"what nobody knows") -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_bytes(data)
        return {name}

    return damage


KINDS |= {
    "a foreign file": _put("notes.txt"),
    "a foreign empty file": _put("empty", b""),
    "a foreign image of a later frame": _put("rgb_99999.png"),
    "a foreign file in a folder": _put("more/files/a.png"),
    "a foreign hidden file": _put(".hidden"),
    "a foreign record": _put(".usdsdg/frames/99999.npz"),
    "a file that a process was writing": _put(".rgb_0001.png.17-4.part"),
}


def _copied(target: Callable[[str], str]) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        name = draw.choice(files(folder, _IMAGES))
        shutil.copyfile(folder / name, folder / target(name))
        return {target(name)}

    return damage


KINDS |= {
    "an image that is there twice": _copied(lambda name: name.replace(".png", " (1).png")),
    "an image of a frame that there is not": _copied(lambda name: "rgb_9" + name[5:]),
}


def _exchanged(pattern: str, *, both: bool) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        names = files(folder, pattern)
        place = draw.randrange(len(names) - 1)
        one, other = names[place], names[place + 1]
        data = (folder / one).read_bytes(), (folder / other).read_bytes()
        assert data[0] != data[1]
        rewrite(folder / other, data[0])
        if both:
            rewrite(folder / one, data[1])
        return {one, other} if both else {other}

    return damage


KINDS |= {
    "two images exchanged": _exchanged(_IMAGES, both=True),
    "the image of the frame before": _exchanged(_IMAGES, both=False),
    "the record of the frame before": _exchanged(_RECORDS, both=False),
}


@kind
def a_renamed_file(folder: Path, draw: random.Random) -> set[str]:
    name = draw.choice(files(folder, _IMAGES))
    (folder / name).rename(folder / f"old_{name}")
    return {name, f"old_{name}"}


def _replaced(make: Callable[[Path], object]) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        name = draw.choice(files(folder, _IMAGES))
        (folder / name).rename(folder.parent / "aside")
        make(folder / name)
        return {name}

    return damage


@kind
def a_pipe_in_place_of_the_recipe(folder: Path, draw: random.Random) -> set[str]:
    (folder / RECIPE).unlink()
    os.mkfifo(folder / RECIPE)
    return {RECIPE}


KINDS |= {
    "a folder in place of a file": _replaced(Path.mkdir),
    "a link in place of a file": _replaced(lambda path: path.symlink_to(path.parent.parent / "aside")),
    "a pipe in place of a file": _replaced(os.mkfifo),
}


@kind
def a_link_to_a_folder(folder: Path, draw: random.Random) -> set[str]:
    (folder / "elsewhere").symlink_to(folder.parent)
    return {"elsewhere"}


def _same(edit: Callable[[Path], object]) -> Damage:
    def damage(folder: Path, draw: random.Random) -> set[str]:
        edit(folder)
        return set()

    return damage


def _touch(paths: Iterable[Path]) -> None:
    for path in paths:
        if path.is_file():
            os.utime(path, (1, 1))


@harmless
def a_journal_closed_by_an_earlier_version(folder: Path, draw: random.Random) -> set[str]:
    path = folder / JOURNAL
    first, *frames, last = path.read_bytes().splitlines(keepends=True)
    told = {name: each for name, each in json.loads(first).items() if name in ("shared", "facts")}
    closing = json.loads(last) | told | {"lines": hashlib.sha256(b"".join(frames)).hexdigest()}
    rewrite(path, b"".join(frames) + json.dumps(closing).encode() + b"\n")
    return set()


HARMLESS |= {
    "nothing": _same(lambda folder: None),
    "other times of files": _same(lambda folder: _touch(folder.rglob("*"))),
    "a page of inspect": _same(lambda folder: (folder / "inspect.html").write_text("page")),
    "a file of the desktop": _same(lambda folder: (folder / ".DS_Store").write_bytes(b"icons")),
    "an empty folder": _same(lambda folder: (folder / "empty").mkdir()),
}
