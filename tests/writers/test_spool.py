"""The spool: what was appended is there, whatever happens to the process, the disk and the folder."""

import errno
import gc
import json
import os
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from usdsdg.errors import OutputNotWritable, WriterError
from usdsdg.writers import spool
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.group import BackendGroup
from usdsdg.writers.spool import Spool

ROOT = Path(__file__).resolve().parents[2]
ROWS = [{"frame": n, "boxes": [[n, 0.1 * n]], "name": "caf\u00e9\n{}"} for n in range(5)]


def filled(backend, rows=ROWS, name="Some/part"):
    made = Spool(backend, name)
    for row in rows:
        made.note({"classes": list(range(row["frame"] // 2))})
        made.append(row["frame"], {key: value for key, value in row.items() if key != "frame"})
    return made


def test_records_come_back_in_the_order_of_frames_and_what_is_known_last_counts(tmp_path):
    made = filled(DiskBackend(tmp_path))
    assert made.path == tmp_path / ".usdsdg/aggregates/Some/part.jsonl"
    for records in (made.so_far(), spool.read(made.path)):
        assert list(records) == list(records) == ROWS
        assert (records.count, records.about) == (5, {"classes": [0, 1]})


def test_records_are_put_in_order_by_a_value(tmp_path):
    rows = [{"frame": number, "name": name} for number, name in enumerate(["b_1", "a_10", "a_9", "b_0", "a_1"])]
    records = filled(DiskBackend(tmp_path), rows).so_far()
    assert list(records.ordered_by("name")) == sorted(rows, key=lambda row: row["name"])


def test_records_so_far_are_not_those_that_follow(tmp_path):
    made = filled(DiskBackend(tmp_path), ROWS[:3])
    before = made.so_far()
    made.append(3, {"boxes": []})
    made.note({"classes": ["other"]})
    assert list(before) == ROWS[:3]
    assert (before.count, before.about) == (3, {"classes": [0]})


def test_a_torn_last_line_is_not_there_and_nothing_else_is_lost(tmp_path):
    whole = filled(DiskBackend(tmp_path)).path.read_bytes()
    last = len(whole) - len(whole.splitlines(keepends=True)[-1])
    torn = tmp_path / "torn.jsonl"
    for size in range(last, len(whole)):
        torn.write_bytes(whole[:size])
        records = spool.read(torn)
        assert (list(records), records.count, records.size) == (ROWS[:-1], 4, last)


def test_a_damaged_line_in_the_middle_is_an_error(tmp_path):
    path = filled(DiskBackend(tmp_path)).path
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], lines[2][:7] + b"\n", *lines[3:]]))
    with pytest.raises(WriterError, match=f"byte {len(lines[0] + lines[1])} is damaged"):
        spool.read(path)


KILLED = """
import os, signal, sys
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.spool import Spool
made = Spool(DiskBackend(sys.argv[1]), "part")
for number in range(1000):
    made.append(number, {"text": "x" * number})
    if number == 700:
        os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_loses_nothing(tmp_path):
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], cwd=ROOT, timeout=120)
    assert done.returncode == -signal.SIGKILL
    found = list(spool.read(tmp_path / ".usdsdg/aggregates/part.jsonl"))
    assert found == [{"frame": number, "text": "x" * number} for number in range(701)]


def test_a_full_disk_is_an_error_and_leaves_whole_lines(tmp_path, monkeypatch):
    made = filled(DiskBackend(tmp_path))
    write = os.write

    def full(descriptor, data):
        if len(data) <= 20:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(descriptor, data[:20])

    with monkeypatch.context() as patched:
        patched.setattr(os, "write", full)
        with pytest.raises(OutputNotWritable, match="the disk is full"):
            made.append(5, {"text": "x" * 100})
    made.append(6, {"text": "y"})
    assert list(spool.read(made.path)) == [*ROWS, {"frame": 6, "text": "y"}]


def test_a_folder_that_is_removed_is_an_error(tmp_path):
    made = filled(DiskBackend(tmp_path / "out"))
    shutil.rmtree(tmp_path / "out")
    with pytest.raises(OutputNotWritable, match="it or its folder was removed"):
        made.append(5, {})
    assert not (tmp_path / "out").exists()


def test_two_that_write_to_one_file_are_an_error(tmp_path):
    backend = DiskBackend(tmp_path)
    first = filled(backend)
    second = filled(backend, ROWS[:2])  # a later writer replaces what was there
    assert list(second.so_far()) == ROWS[:2]
    with pytest.raises(WriterError, match="another writer"):
        first.append(5, {})


class Bucket(BaseBackend):
    def write_blob(self, path, data):
        raise AssertionError("nothing is sent to a bucket before the end")


def test_without_a_folder_the_file_is_a_temporary_one(tmp_path):
    made = filled(Bucket())
    path, records = made.path, made.so_far()
    del made
    gc.collect()
    assert list(records) == ROWS
    del records
    gc.collect()
    assert not path.exists()
    group = BackendGroup([Bucket(), DiskBackend(tmp_path)])
    assert filled(group).path.is_relative_to(tmp_path)


def test_lines_are_json_that_other_programs_read(tmp_path):
    lines = filled(DiskBackend(tmp_path)).path.read_text().splitlines()
    assert [json.loads(line) for line in lines if "frame" in json.loads(line)] == ROWS


def test_records_so_far_are_read_after_another_writer_has_begun(tmp_path):
    before = filled(DiskBackend(tmp_path)).so_far()
    other = filled(DiskBackend(tmp_path), ROWS[3:])
    assert list(before) == ROWS
    assert list(other.so_far()) == ROWS[3:]


def test_threads_read_one_spool_at_once(tmp_path):
    rows = [{"frame": number, "text": "x" * (number % 97 * 40)} for number in range(2000)]
    records = filled(DiskBackend(tmp_path), rows).so_far()
    with ThreadPoolExecutor(4) as pool:
        assert all(found == rows for found in pool.map(list, [records] * 4))
