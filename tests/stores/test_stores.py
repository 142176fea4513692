"""What every store promises: folders, memory, and buckets on a server that speaks S3's protocol."""

import itertools
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.stores.servers import Bucket, only_ours
from usdsdg.errors import OutputNotWritable, StoreError, Unsupported
from usdsdg.stores import open_store

_names = itertools.count()
KEYS = [
    "a b.txt",
    "100%.txt",
    "a%20b",
    "%2e%2e",
    "ü/é̈.json",
    "日本.png",
    "a+b&c=d",
    "#x?y",
    "a*b",
    "'q\"",
    "~",
    "-",
    "..a",
    "a.",
    "a\\b",
    "x" * 200,
]


@pytest.fixture(params=["folder", "file URL", "memory", "memory below a prefix", "S3"])
def store(request, tmp_path, monkeypatch):
    if request.param == "S3":
        only_ours(monkeypatch, str(tmp_path / "none"))
        bucket = Bucket()
        return open_store(f"s3://{bucket.name}/runs/a b%20", endpoint_url=bucket.url)
    where = {
        "folder": str(tmp_path / "a folder"),
        "file URL": (tmp_path / "ü b").as_uri(),
        "memory": f"memory://{next(_names)}",
        "memory below a prefix": f"memory://{next(_names)}/runs/a b%20",
    }
    return open_store(where[request.param])


def test_what_is_put_comes_back(store):
    store.put("a/b.bin", b"123")
    store.put("empty", b"")
    store.put("chunks", [b"ab", memoryview(b"cd")])
    store.put("a/b.bin", b"4")
    assert [store.get(each) for each in ("a/b.bin", "empty", "chunks")] == [b"4", b"", b"abcd"]
    assert (store.size("chunks"), store.size("none"), store.size("a")) == (4, None, None)
    with pytest.raises(FileNotFoundError, match="none"):
        store.get("none")


@pytest.mark.parametrize("key", KEYS)
def test_odd_names_stay_as_they_are(store, key):
    store.put(f"in/{key}", key.encode())
    assert store.get(f"in/{key}") == key.encode()
    assert list(store.list()) == [(f"in/{key}", len(key.encode()))]
    assert store.put_if_absent(f"in/{key}", b"") is False
    store.delete(f"in/{key}")
    assert list(store.list()) == []


@pytest.mark.parametrize("key", ["..", "../x", "a/../../x", "/etc/passwd", "", "/", ".", "a\0b"])
def test_paths_never_leave_the_store(store, key):
    for call in (store.get, store.size, store.delete, lambda path: store.put(path, b""), store.get_entry):
        with pytest.raises(StoreError, match=r"would leave|is no name"):
            call(key)


def test_large_files_come_whole(store):
    data = bytes(range(256)) * (9 << 12)  # 9 MB: two parts
    chunks = [memoryview(data)[start : start + (1 << 20)] for start in range(0, len(data), 1 << 20)]
    store.put("bytes", data)
    store.put("chunks", chunks)
    store.put("nothing", Nothing())
    assert store.get("bytes") == store.get("chunks") == data
    assert store.get("nothing") == b""


class Nothing:
    """Chunks of which there are none, which nobody knows before."""

    def __iter__(self):
        return iter(())


def test_lists_in_several_pages_are_complete(tmp_path, monkeypatch):
    only_ours(monkeypatch, str(tmp_path / "none"))
    bucket = Bucket()
    bucket.fill(f"many/n/{i:04}" for i in range(2003))
    store = open_store(f"s3://{bucket.name}/many", endpoint_url=bucket.url)
    assert sorted(store.list()) == [(f"n/{i:04}", 0) for i in range(2003)]


def test_double_slashes_and_dots_are_one_name(store):
    store.put("a//./b", b"1")
    assert store.get("a/b") == b"1"


def test_lists_go_below_folders_not_names(store):
    for key in ("a", "ab/c", "b/x", "b/y/z", "bb"):
        store.put(key, b"12")
    assert sorted(store.list()) == [("a", 2), ("ab/c", 2), ("b/x", 2), ("b/y/z", 2), ("bb", 2)]
    assert sorted(store.list("b")) == sorted(store.list("b/")) == [("b/x", 2), ("b/y/z", 2)]
    assert list(store.list("none")) == []


def test_delete_is_content_with_nothing(store):
    store.put("a", b"")
    store.delete("a")
    store.delete("a")
    assert store.size("a") is None


def test_put_if_absent_keeps_the_first(store):
    assert store.put_if_absent("lock", b"mine") is True
    assert store.put_if_absent("lock", b"yours") is False
    assert store.put_if_absent("lock", b"mine") is False
    assert store.get("lock") == b"mine"
    store.delete("lock")
    assert store.put_if_absent("lock", b"yours") is True


def test_put_if_match_sees_changes(store):
    store.put("lease", b"1")
    old = store.get_entry("lease")
    assert old.data == b"1"
    assert store.put_if_match("lease", b"2", old.etag) is True
    assert store.put_if_match("lease", b"3", old.etag) is False
    assert store.get("lease") == b"2"
    store.delete("lease")
    assert store.put_if_match("lease", b"4", old.etag) is False
    assert store.size("lease") is None


def test_of_many_threads_one_makes_the_file(store):
    with ThreadPoolExecutor(16) as pool:
        for turn in range(10):
            won = list(pool.map(lambda i, t=turn: store.put_if_absent(f"lock{t}", b"%d" % i), range(16)))
            assert won.count(True) == 1
            assert store.get(f"lock{turn}") == b"%d" % won.index(True)


def test_counting_by_many_threads_loses_nothing(store):
    """Optimistic counting: whoever was overtaken reads again."""
    store.put("count", b"0")

    def add(_):
        while True:
            entry = store.get_entry("count")
            if store.put_if_match("count", b"%d" % (int(entry.data) + 1), entry.etag):
                return

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(add, range(40)))
    assert store.get("count") == b"40"


COUNTING = """
import sys
from usdsdg.stores import open_store
store = open_store(sys.argv[1])
for _ in range(50):
    while True:
        entry = store.get_entry("count")
        if store.put_if_match("count", b"%d" % (int(entry.data) + 1), entry.etag):
            break
"""


def test_counting_by_processes_in_a_folder_loses_nothing(tmp_path):
    store = open_store(tmp_path)
    store.put("count", b"0")
    root = str(Path(__file__).resolve().parents[2])
    running = [subprocess.Popen([sys.executable, "-c", COUNTING, str(tmp_path)], cwd=root) for _ in range(3)]
    assert [each.wait(60) for each in running] == [0, 0, 0]
    assert store.get("count") == b"150"
    assert [path.name for path in tmp_path.iterdir()] == ["count"]


def test_folders_hide_what_is_being_written(tmp_path):
    (tmp_path / ".x.png.1-2.part").write_bytes(b"half")
    (tmp_path / ".hidden").write_bytes(b"1")
    assert list(open_store(tmp_path).list()) == [(".hidden", 1)]


def test_a_folder_that_cannot_be_written_says_why(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    store = open_store(tmp_path / "file")
    for call in (store.put, store.put_if_absent):
        with pytest.raises(OutputNotWritable, match="file"):
            call("x", b"1")


def test_without_links_a_file_is_still_made_once(tmp_path, monkeypatch):
    def no_links(*_):
        raise OSError(1, "not permitted")

    monkeypatch.setattr("os.link", no_links)
    store = open_store(tmp_path)
    assert (store.put_if_absent("a", b"1"), store.put_if_absent("a", b"2")) == (True, False)
    assert store.get("a") == b"1"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_without_obstore_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "obstore", None)
    with pytest.raises(Unsupported, match=r"pip install 'usdsdg\[stores\]'"):
        open_store("s3://bucket/x")
