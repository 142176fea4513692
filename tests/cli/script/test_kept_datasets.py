"""A script that is run again does not lose the dataset that it once made, whatever it does to its output folder."""

import os
import shutil

import pytest

from tests.cli.datasets import content, run
from tests.sampled_cases import sampled
from tests.verify.damaged import SCRIPT
from usdsdg.cli.script.kept_datasets import datasets_kept, read_only

# As users' scripts begin.
REMOVES = "import shutil\nshutil.rmtree({folder!r}{more})\n"


def script(folder, *, more=", ignore_errors=True", before="", frames=4):
    file = folder / "script.py"
    text = SCRIPT.replace("sys.argv[2]", repr(str(folder / "out"))).replace("int(sys.argv[1])", str(frames))
    first = before or REMOVES.format(folder=str(folder / "out"), more=more)
    file.write_text(first + text)
    return file


def made(file, *options):
    return run(["-m", "usdsdg", "run", "-q", "--device", "cpu", "--seed", "5", *options, str(file)])


def reproduce(folder):
    return run(["-m", "usdsdg", "reproduce", "-q", str(folder), "--device", "cpu"])


@pytest.mark.parametrize("more", sampled([", ignore_errors=True", ") if os.path.exists(sys.argv[0]) else (None"]))
def test_a_check_keeps_the_dataset_that_the_script_removes(tmp_path, more):
    (tmp_path / "out").mkdir()  # rmtree without ignore_errors needs it
    file = script(tmp_path, more=more)
    file.write_text("import os, sys\n" + file.read_text())
    made(file).check_returncode()
    before = content(tmp_path / "out")
    done = reproduce(tmp_path / "out")
    assert content(tmp_path / "out") == before
    assert done.returncode == 0, done.stderr + done.stdout
    assert "0 different" in done.stdout
    assert done.stderr.count("the script's removal of") == 1


@pytest.mark.parametrize(
    "change",
    sampled(
        [
            "for each in glob.glob(out + '/*'):\n    os.remove(each)",
            "os.rename(out, out + '_old')",
            "open(out + '/notes.txt', 'w').write('again')",
            "os.truncate(glob.glob(out + '/*.png')[0], 0)",
        ],
        2,
    ),
)
def test_a_check_refuses_what_the_script_does_to_its_files(tmp_path, change):
    head = f"import os, glob\nout = {str(tmp_path / 'out')!r}\nif os.path.exists(out + '/rgb_0000.png'):\n    "
    file = script(tmp_path, before=head + change.replace("\n", "\n    ") + "\n", frames=1)
    made(file).check_returncode()
    before = content(tmp_path / "out")
    done = reproduce(tmp_path / "out")
    assert content(tmp_path / "out") == before
    assert done.returncode == 1
    assert done.stderr.count("which is refused") == 1
    assert "is kept as it is" in done.stderr


def test_processes_of_a_script_that_removes_its_folder_keep_the_files_of_the_others(tmp_path):
    file = script(tmp_path)
    made(file).check_returncode()
    whole = content(tmp_path / "out")
    done = made(file, "--workers", "2")
    assert done.returncode == 0, done.stderr
    found = content(tmp_path / "out")
    assert found.keys() - {".usdsdg/journal.jsonl"} == whole.keys() - {".usdsdg/journal.jsonl"}
    assert all(found[name] == whole[name] for name in whole if not name.startswith(".usdsdg/"))


def test_a_run_that_is_gone_on_with_keeps_its_frames(tmp_path):
    file = script(tmp_path)
    made(file).check_returncode()
    (tmp_path / "out/rgb_0000.png").write_bytes(b"made before")
    done = made(file, "--resume")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/rgb_0000.png").read_bytes() == b"made before"
    assert "the script's removal of" in done.stderr


def test_other_folders_and_reading_are_left_to_the_script(tmp_path):
    kept, other = tmp_path / "kept", tmp_path / "kept_other"
    for folder in (kept, other):
        (folder / "below").mkdir(parents=True)
        (folder / "below/file").write_text("text")
    (tmp_path / "link").symlink_to(kept)
    with read_only(kept):
        assert (kept / "below/file").read_text() == "text"
        shutil.rmtree(other)
        shutil.rmtree(kept / "below")
        shutil.rmtree(tmp_path)
        with pytest.raises(PermissionError, match="is kept as it is"):
            (tmp_path / "link/below/file").unlink()
        with pytest.raises(PermissionError, match="is kept as it is"):
            os.rename(tmp_path, tmp_path.with_name("moved"))
        (tmp_path / "link").unlink()
    assert not other.exists()
    assert (kept / "below/file").read_text() == "text"
    shutil.rmtree(kept)
    assert not kept.exists()


def test_parts_may_remove_folders_without_a_dataset(tmp_path):
    for name in ("own/temporary", "own/.usdsdg", "other"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "own/.usdsdg/recipe.json").write_text("{}")
    with datasets_kept():
        shutil.rmtree(tmp_path)
        shutil.rmtree(tmp_path / "own/temporary")
        shutil.rmtree(tmp_path / "other")
    assert [path.name for path in tmp_path.rglob("*")] == ["own", ".usdsdg", "recipe.json"]
