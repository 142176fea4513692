"""Output folders: one run at a time, and none is lost by another."""

import errno
import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from tests import forked
from usdsdg import operating_system
from usdsdg.errors import DatasetInTheWay, OutputNotWritable, StoreError, UsdsdgError, UsdsdgWarning, forget_warnings
from usdsdg.stores import locks
from usdsdg.stores.locks import FileLock, Locked
from usdsdg.stores.whole_file import check_writable
from usdsdg.writers.journal import merge
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.frames import FrameFiles
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.places.place_locks import shared_lock, whole_locks
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import SCRIPT, Recipe
from usdsdg.writers.journal.run import Run

ROOT = Path(__file__).resolve().parents[3]


def recipe(**facts):
    return Recipe(**{"command": "generate", "source": {"name": "a.yaml", "sha256": "1"}, "device": "cpu"} | facts)


def write_frame(folder, number, text=b"x"):
    name = f"{number}.png"
    (folder.path / name).write_bytes(text)
    frame = FrameFiles(number)
    frame.note(str(folder.path), name, (len(text), "0"))
    folder.append([{"frame": number, "files": frame.folders[str(folder.path)]}])


def run(path, mode=Mode.NEW, portion=None, frames=(), complete=True, **facts):
    folder = DatasetFolder(FolderPlace(path), recipe(**facts), mode, portion)
    for number in frames:
        write_frame(folder, number)
    folder.close(complete=complete)


@pytest.mark.parametrize(
    ("facts", "named"),
    [
        ({"source": {"name": "a.yaml", "sha256": "2"}}, 'source.sha256: "1" there, "2" now'),
        ({"arguments": ["num_frames=3"]}, r'arguments: \[\] there, \["num_frames=3"\] now'),
        ({"seed": 5}, "seed: null there, 5 now"),
        ({"device": "cuda"}, 'device: "cpu" there, "cuda" now'),
        ({"versions": {"usdsdg": "9"}}, "versions.usdsdg"),
        ({"classes": "cat,dog"}, "classes"),
    ],
)
@pytest.mark.parametrize("mode", [Mode.NEW, Mode.RESUME])
def test_another_recipe_is_in_the_way_and_nothing_is_lost(tmp_path, facts, named, mode):
    run(tmp_path, frames=(0, 1))
    with pytest.raises(DatasetInTheWay, match=named):
        run(tmp_path, mode, **facts)
    assert (tmp_path / "1.png").exists()
    run(tmp_path, Mode.OVERWRITE, frames=(0,), **facts)
    assert {path.name for path in tmp_path.iterdir()} == {"0.png", ".usdsdg"}


def test_an_unfinished_run_is_gone_on_with_or_removed_only_when_asked_for(tmp_path):
    run(tmp_path, frames=(0, 1), complete=False)
    with pytest.raises(DatasetInTheWay, match="--resume"):
        run(tmp_path)
    going_on = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.RESUME, None)
    assert [going_on.has(number) for number in range(3)] == [True, True, False]
    going_on.release()
    run(tmp_path, Mode.OVERWRITE)
    assert not (tmp_path / "0.png").exists()


def test_a_complete_run_of_the_same_recipe_and_one_of_the_same_script_are_replaced(tmp_path):
    run(tmp_path, frames=(0, 1, 2))
    (tmp_path / "notes.txt").write_text("mine")
    run(tmp_path, frames=(0,))
    assert {path.name for path in tmp_path.iterdir()} == {"0.png", ".usdsdg", "notes.txt"}
    run(tmp_path, Mode.REPLACE, frames=(1,), complete=False, source={"name": "a.yaml", "sha256": "another"})
    run(tmp_path, Mode.REPLACE, frames=(2,))
    assert {path.name for path in tmp_path.iterdir()} == {"2.png", ".usdsdg", "notes.txt"}
    with pytest.raises(DatasetInTheWay, match=r"of another recipe, of a\.yaml"):
        run(tmp_path, Mode.REPLACE, source={"name": "b.py", "sha256": "1"})
    with pytest.raises(DatasetInTheWay, match=r"remove that run with usdsdg run --overwrite 'my b\.py'\.$"):
        run(tmp_path, Mode.REPLACE, command=SCRIPT, source={"name": "my b.py", "sha256": "1"})


def test_a_run_that_is_replaced_is_told_unless_that_was_asked_for(tmp_path, recwarn):
    forget_warnings()
    run(tmp_path, frames=(0,))
    run(tmp_path, Mode.OVERWRITE, frames=(0,))
    assert not recwarn
    with pytest.warns(UsdsdgWarning, match="the files of the earlier run there are replaced"):
        run(tmp_path)


def test_files_of_others_cannot_be_gone_on_with(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(DatasetInTheWay, match="no recipe"):
        run(tmp_path, Mode.RESUME)


@pytest.mark.parametrize("portion", [None, Portion(0, 1)])
def test_frames_of_a_run_whose_recipe_is_gone_are_not_those_of_the_next_one(tmp_path, portion):
    run(tmp_path, portion=portion, frames=(0,))
    (tmp_path / ".usdsdg/recipe.json").unlink()
    for mode in (Mode.NEW, Mode.REPLACE, Mode.RESUME):
        with pytest.raises(DatasetInTheWay, match=r"a journal but no .usdsdg/recipe.json.* --overwrite\.$"):
            run(tmp_path, mode, seed=5)
    for mode in Mode:
        with pytest.raises(DatasetInTheWay, match="remove this one first"):
            run(tmp_path, mode, Portion(0, 2), seed=5)
    assert (tmp_path / "0.png").is_file()
    run(tmp_path, Mode.OVERWRITE, frames=(1,), seed=5)
    assert {path.name for path in tmp_path.iterdir()} == {"1.png", ".usdsdg"}


@pytest.mark.parametrize("mode", [Mode.NEW, Mode.REPLACE, Mode.OVERWRITE])
@pytest.mark.parametrize("portion", [None, Portion(0, 1)])
def test_a_part_is_not_mixed_with_an_earlier_run(tmp_path, mode, portion):
    run(tmp_path, portion=portion, frames=(0,))
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    facts = {} if portion is None else {"seed": 7}  # the same run as a whole, or a part of another
    with pytest.raises(DatasetInTheWay, match="remove"):
        run(tmp_path, mode if portion is None else Mode.OVERWRITE, Portion(0, 1), frames=(0,), **facts)
    assert {path: path.read_bytes() for path in before} == before


def test_a_part_of_another_recipe_of_a_script_is_refused_beside_others_and_replaces_itself_alone(tmp_path):
    run(tmp_path, Mode.REPLACE, Portion(0, 2), frames=(0, 1), arguments=["cube"])
    for arguments in (["ball"], ["cone"]):
        run(tmp_path, Mode.REPLACE, Portion(0, 2), frames=(0, 1), arguments=arguments)
    with pytest.raises(DatasetInTheWay, match=r'arguments: \["cone"\] there, \["cube"\] now'):
        run(tmp_path, Mode.REPLACE, Portion(2, 4), frames=(2, 3), arguments=["cube"])
    assert not (tmp_path / "2.png").exists()
    run(tmp_path, Mode.REPLACE, Portion(2, 4), frames=(2, 3), arguments=["cone"])
    assert merge.join(FolderPlace(tmp_path)) == 4


@pytest.mark.parametrize("name", ["a file", "a file/below", "x" * 300])
def test_a_path_that_cannot_be_a_folder_is_an_error_that_asks_for_another(tmp_path, name):
    (tmp_path / "a file").touch()
    with pytest.raises(UsdsdgError, match="Choose another output_dir"):
        run(tmp_path / name)


def _in_place_of(file):
    """Return what may be in the place of a file."""
    return {"pipe": lambda: os.mkfifo(file), "folder": file.mkdir}


@pytest.mark.parametrize("name", ["journal.jsonl", "recipe.json", "classes.json", "aggregates/W/a.jsonl"])
@pytest.mark.parametrize("what", ["pipe", "folder"])
def test_what_is_no_file_is_an_error_that_ends(tmp_path, name, what):
    """A pipe would be waited for without end, so what is read is tried by a process."""
    claim = "from tests.writers.journal.test_folders import *; run(Path(sys.argv[1]), Mode.RESUME)"
    run(tmp_path, frames=(0,))
    file = tmp_path / ".usdsdg" / name
    file.unlink(missing_ok=True)
    file.parent.mkdir(parents=True, exist_ok=True)
    _in_place_of(file)[what]()
    done = forked.run(["-c", claim, str(tmp_path)], cwd=ROOT, timeout=60)
    if name.startswith("aggregates"):  # of which the journal tells nothing
        assert done.returncode == 0, done.stderr
        return
    *_, last = done.stderr.splitlines()
    assert re.match(r"usdsdg.errors.\w+: .*(in the way|is not read|is a folder|Is a directory)", last), done.stderr


def test_a_listed_path_outside_of_the_folder_is_never_removed(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (tmp_path / "precious.txt").write_text("mine")
    run(out, frames=(0,))
    journal = out / ".usdsdg/journal.jsonl"
    line = {"frame": 0, "files": {"../precious.txt": [1, "0"], str(tmp_path / "precious.txt"): [1, "0"]}}
    journal.write_text(json.dumps(line) + "\n" + journal.read_text().splitlines()[-1] + "\n")
    run(out, Mode.OVERWRITE)
    assert (tmp_path / "precious.txt").read_text() == "mine"


def test_what_has_taken_the_place_of_a_listed_file_does_not_keep_a_run_from_its_removal(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (tmp_path / "precious.txt").write_text("mine")
    run(out, frames=(0, 1, 2))
    for number in range(3):
        (out / f"{number}.png").unlink()
    (out / "0.png").mkdir()
    (out / "0.png/notes.txt").write_text("mine")
    (out / "1.png").symlink_to(tmp_path / "precious.txt")
    (out / "2.png").symlink_to("0.png/notes.txt")
    run(out, Mode.OVERWRITE)
    assert (out / "0.png/notes.txt").read_text() == (tmp_path / "precious.txt").read_text() == "mine"
    assert sorted(path.name for path in out.iterdir()) == [".usdsdg", "0.png"]


def test_parts_are_written_beside_each_other_and_one_part_by_one_process(tmp_path):
    first = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, Portion(0, 2))
    second = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, Portion(2, 4))
    with pytest.raises(DatasetInTheWay, match="another process"):
        DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, Portion(0, 2))
    with pytest.raises(DatasetInTheWay, match="another process"):
        DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, None)
    for folder in (first, second):
        folder.release()


@pytest.mark.parametrize("portion", [None, Portion(0, 2)])
def test_a_run_that_goes_on_is_told_from_one_that_was_not_finished(tmp_path, portion):
    def check() -> None:
        later = Run()
        later.begin(recipe(), Mode.NEW, portion)
        later.check(tmp_path)

    first = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, portion)
    write_frame(first, 0)
    with pytest.raises(DatasetInTheWay, match="another process is writing"):
        check()
    first.release()
    with pytest.raises(DatasetInTheWay, match="an unfinished run of this recipe"):
        check()
    first = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.RESUME, portion)  # which `check` has not kept out
    first.release()


HOLDER = """
import sys, time
from pathlib import Path
from usdsdg.stores.locks import FileLock
lock = FileLock(Path(sys.argv[1]))
print("locked", flush=True)
time.sleep(60)
"""


def test_a_lock_ends_with_its_process(tmp_path):
    path = tmp_path / "lock"
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, str(path)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "locked\n"
    with pytest.raises(Locked):
        FileLock(path)
    with pytest.raises(Locked):
        FileLock(path, shared=True)
    holder.kill()
    holder.wait()
    FileLock(path).release()


def test_a_file_system_without_locks_is_told_as_such(tmp_path, monkeypatch):
    def refused(*_, **__):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(locks, "lock", refused)
    with pytest.raises(OutputNotWritable, match="No locks available"):
        DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, None)
    with pytest.raises(OutputNotWritable, match="No locks available"):
        shared_lock(FolderPlace(tmp_path))


def test_a_process_that_lets_others_make_parts_needs_a_dataset_that_none_makes_alone(tmp_path):
    alone = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, None)
    with pytest.raises(DatasetInTheWay, match="another process"):
        shared_lock(FolderPlace(tmp_path))
    alone.release()
    shared_lock(FolderPlace(tmp_path)).release()


def test_a_lock_of_a_killed_process_that_let_others_make_parts_goes(tmp_path):
    run(tmp_path, frames=[0], complete=False)
    (tmp_path / ".usdsdg/.workers.lock").touch()
    run(tmp_path, Mode.RESUME, frames=[1])
    assert not (tmp_path / ".usdsdg/.workers.lock").exists()
    assert sorted(each.name for each in tmp_path.glob("*.png")) == ["0.png", "1.png"]


def test_a_file_that_is_replaced_is_locked_anew(tmp_path):
    path = tmp_path / "lock"
    lock = FileLock(path)
    path.rename(tmp_path / "old")
    path.write_text("new")
    other = FileLock(path)
    lock.release()
    with pytest.raises(Locked):
        FileLock(path)
    other.release()


@pytest.mark.parametrize("written", ["{out}", "{top}", "--out={out}", "out"])
@pytest.mark.parametrize("names", [("a", "b"), ("a", "day=3"), ("x=1&y=2", "#b?x==")])
def test_arguments_that_say_where_the_data_are_are_no_part_of_the_recipe(tmp_path, monkeypatch, written, names):
    found = []
    for name in names:
        top = tmp_path / name
        top.mkdir()
        monkeypatch.chdir(top)
        argument = written.format(out=top / "out", top=top)
        found.append(recipe(arguments=["--size", "3", argument, "/elsewhere/x"]).of(top / "out").arguments)
    assert found[0] == found[1]
    assert found[0][:2] == ["--size", "3"]
    assert found[0][3] == "/elsewhere/x"


def test_a_part_that_goes_on_leaves_what_processes_of_other_parts_are_writing(tmp_path):
    run(tmp_path, portion=Portion.of_frames("0:1"), frames=(0,))
    being_written = tmp_path / ".1.png.17-4.part"
    being_written.write_bytes(b"half")
    own = tmp_path / ".usdsdg/parts/0-1/.spool.17-5.part"
    own.write_bytes(b"half")
    DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.RESUME, Portion.of_frames("0:1")).release()
    assert being_written.exists()
    assert not own.exists()


def test_a_folder_in_which_others_begin_is_empty(tmp_path):
    place = FolderPlace(tmp_path)
    (tmp_path / ".17-0.part").touch()  # another process tries whether it can write
    run(tmp_path / "coco", frames=(0,))  # of another writer
    (tmp_path / "yolo/.usdsdg").mkdir(parents=True)
    (tmp_path / "voc").mkdir()
    assert not place.has_files()
    DatasetFolder(place, recipe(), Mode.RESUME, None).release()
    (tmp_path / "voc/a.png").touch()
    assert place.has_files()


def test_a_dataset_that_was_begun_below_another_one_keeps_nobody_from_going_on(tmp_path):
    run(tmp_path / "below", frames=(0,), complete=False)
    run(tmp_path, Mode.RESUME, frames=(0,))
    assert (tmp_path / "0.png").exists()


def test_a_run_that_goes_on_leaves_what_is_being_written_to_a_dataset_below(tmp_path):
    run(tmp_path, frames=(0,), complete=False)
    run(tmp_path / "below", frames=(0,), complete=False)
    for folder in (tmp_path, tmp_path / "below", tmp_path / "below/images"):
        folder.mkdir(exist_ok=True)
        (folder / ".1.png.17-4.part").write_bytes(b"half")
    DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.RESUME, None).release()
    left = {path.parent.name for path in tmp_path.rglob("*.part")}
    assert left == {"below", "images"}


@pytest.mark.parametrize("damage", ["{", "[]"])
def test_a_program_is_told_the_command_that_removes_a_run_with_a_damaged_recipe(tmp_path, damage):
    run(tmp_path, frames=(0,))
    (tmp_path / ".usdsdg/recipe.json").write_text(damage)
    with pytest.raises(UsdsdgError, match=r"Remove that run with --overwrite\.$"):
        run(tmp_path)
    with pytest.raises(UsdsdgError, match=r"Remove that run with usdsdg run --overwrite b\.py\.$"):
        run(tmp_path, Mode.REPLACE, command=SCRIPT, source={"name": "b.py", "sha256": "1"})


def test_a_journal_that_is_a_link_to_nothing_is_named(tmp_path):
    run(tmp_path, frames=(0,))
    journal = tmp_path / ".usdsdg/journal.jsonl"
    journal.unlink()
    journal.symlink_to(tmp_path / "gone/journal.jsonl")
    with pytest.raises(OutputNotWritable, match=rf"{journal} is a link to .*gone/journal.jsonl, .* Remove the link"):
        run(tmp_path, Mode.REPLACE)
    assert journal.is_symlink()


@pytest.mark.skipif(operating_system.resource is None, reason="this system has no such limits")
def test_limits_of_files_say_which_one_is_to_be_raised(tmp_path):
    code = (
        "import resource, sys; from pathlib import Path; from usdsdg.stores.whole_file import write_whole\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "write_whole(Path(sys.argv[1]) / 'a', bytes(2000))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, timeout=60)
    assert "cannot be written: the file would be larger than this process may write. Raise the limit (ulimit -f)" in (
        done.stderr
    )
    assert not list(tmp_path.iterdir())


def test_an_output_folder_that_is_a_link_to_nothing_is_named(tmp_path):
    link = tmp_path / "out"
    link.symlink_to(tmp_path / "disk/out")
    with pytest.raises(
        OutputNotWritable, match=rf"{link} is a link to .*disk/out, which is not there\. Remove the link"
    ):
        check_writable(link)


@pytest.mark.parametrize("contents", [("1", "1"), ("1", "2")])
def test_parts_that_were_made_with_other_content_of_an_asset_are_joined_with_a_warning(tmp_path, contents):
    for number, content in enumerate(contents):
        part = DatasetFolder(FolderPlace(tmp_path), recipe(), Mode.NEW, Portion(number, number + 1))
        assets = {f"box.usd {content}": {"name": "box.usd", "sha256": content, "path": "parts/box.usd"}}
        part.note_facts("assets", assets)
        write_frame(part, number)
        part.close(complete=True)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert merge.join(FolderPlace(tmp_path)) == 2
    told = [str(each.message) for each in said if "different content of parts/box.usd" in str(each.message)]
    assert len(told) == (contents[0] != contents[1])


def test_a_store_that_denies_its_locks_is_named_and_not_the_copy_of_its_files(tmp_path):
    class Denying(FolderPlace):
        def locks(self, portion=None):
            raise StoreError("s3://b/out cannot be listed: the credentials do not allow it.")

        shared_lock = locks

    place = Denying(tmp_path)
    for take in (
        lambda: DatasetFolder(place, recipe(), Mode.NEW, None),
        lambda: whole_locks(place),
        lambda: shared_lock(place),
    ):
        with pytest.raises(StoreError, match=r"^s3://b/out cannot be listed: the credentials do not allow it\.$"):
            take()


def test_a_whole_dataset_that_has_lost_its_class_table_keeps_its_recipe(tmp_path):
    table = {"tables": [{"filter": "class:*", "classes": [{"name": "cube"}]}]}
    (tmp_path / ".usdsdg").mkdir()
    (tmp_path / ".usdsdg/classes.json").write_text(json.dumps(table))
    run(tmp_path, frames=(0,))
    before = {name: (tmp_path / ".usdsdg" / name).read_bytes() for name in ("recipe.json", "journal.jsonl")}
    assert json.loads(before["recipe.json"])["class_table"] == {"class:*": ["cube"]}
    (tmp_path / ".usdsdg/classes.json").unlink()
    run(tmp_path, Mode.RESUME)
    assert {name: (tmp_path / ".usdsdg" / name).read_bytes() for name in before} == before
