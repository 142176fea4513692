"""Files of a store that are appended to in pieces, whoever has died meanwhile."""

import pytest

from usdsdg.stores.folder import FolderStore
from usdsdg.stores.mirror import Mirror


@pytest.fixture
def store(tmp_path):
    return FolderStore(tmp_path / "store")


def mirror(store):
    return Mirror(store, "d", lambda name: not name.startswith("d/other"), lambda name: name.endswith(".jsonl"))


def append(place, name, text):
    file = place.path / name
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "a") as stream:
        stream.write(text)


def objects(store):
    return {name: store.get(name) for name, _ in store.list()}


def test_what_is_appended_is_a_piece_and_another_mirror_has_it(store):
    first, second = mirror(store), mirror(store)
    append(first, "d/j.jsonl", "one\n")
    first.push()
    append(first, "d/j.jsonl", "two\n")
    first.push()
    assert list(objects(store).values()) == [b"one\n", b"two\n"]
    second.pull()
    assert (second.path / "d/j.jsonl").read_text() == "one\ntwo\n"
    append(first, "d/j.jsonl", "three\n")
    first.push(whole=True)
    assert objects(store) == {"d/j.jsonl": b"one\ntwo\nthree\n"}
    second.pull()
    assert (second.path / "d/j.jsonl").read_text() == "one\ntwo\nthree\n"
    append(first, "d/j.jsonl", "four\n")
    first.push()
    assert sorted(objects(store).values()) == [b"four\n", b"one\ntwo\nthree\n"]
    second.pull()
    assert (second.path / "d/j.jsonl").read_text() == "one\ntwo\nthree\nfour\n"


def test_pieces_that_a_dead_process_did_not_remove_are_not_read(store):
    first = mirror(store)
    append(first, "d/j.jsonl", "one\n")
    first.push()
    append(first, "d/j.jsonl", "two\n")
    first.push()
    pieces = objects(store)
    (first.path / "d/j.jsonl").write_text("one\n")  # shortened to what is whole
    first.push(whole=True)
    for name, data in pieces.items():
        store.put(name, data)
    second = mirror(store)
    second.pull()
    assert (second.path / "d/j.jsonl").read_text() == "one\n"
    append(second, "d/j.jsonl", "2\n")
    second.push()
    third = mirror(store)
    third.pull()
    assert (third.path / "d/j.jsonl").read_text() == "one\n2\n"
    second.push(whole=True)
    assert objects(store) == {"d/j.jsonl": b"one\n2\n"}


def test_files_that_were_removed_are_removed_and_others_are_left(store):
    store.put("d/other.jsonl", b"x")
    first, second = mirror(store), mirror(store)
    for name in ("d/a.json", "d/j.jsonl", "d/parts/1/j.jsonl"):
        append(first, name, name)
    first.push()
    second.pull()
    assert (second.path / "d/parts/1/j.jsonl").exists()
    (first.path / "d/parts/1/j.jsonl").unlink()
    (first.path / "d/a.json").write_text("new")
    first.push()
    second.pull()
    assert not (second.path / "d/parts/1/j.jsonl").exists()
    assert (second.path / "d/a.json").read_text() == "new"
    assert set(objects(store)) == {"d/a.json", "d/j.jsonl.pieces/new-000000000000", "d/other.jsonl"}


def test_pieces_that_are_put_together_while_they_are_read(store, monkeypatch):
    first, second = mirror(store), mirror(store)
    append(first, "d/j.jsonl", "one\n")
    first.push()
    read = store.get

    def get(path):
        monkeypatch.setattr(store, "get", read)
        first.push(whole=True)
        return read(path)

    monkeypatch.setattr(store, "get", get)
    second.pull()
    assert (second.path / "d/j.jsonl").read_text() == "one\n"
