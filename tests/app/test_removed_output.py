"""A script may remove or move its own output folder after its last file."""

import json
import sys
from pathlib import Path

import pytest

from tests import forked

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
import tempfile
import usdsdg as rep
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome")
product = rep.create.render_product(camera, (32, 24))
with tempfile.TemporaryDirectory() as folder:
    writer = rep.writers.get("CocoWriter", init_params={"output_dir": folder, "plain_names": True})
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
print("removed")
"""


MOVED = """
import errno
import os
import shutil
import sys
import usdsdg as rep
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome")
product = rep.create.render_product(camera, (32, 24))
for name, options in (("BasicWriter", {"rgb": True}), ("CocoWriter", {"plain_names": True})):
    writer = rep.writers.get(name, init_params={"output_dir": os.path.join(sys.argv[1], name), **options})
    writer.attach(product)
rep.orchestrator.run_until_complete(num_frames=2)
if "move" in sys.argv:
    os.rename(sys.argv[1], sys.argv[1] + " moved")
if "disk" in sys.argv:

    def refuse(*paths, **options):
        raise OSError(errno.EXDEV, os.strerror(errno.EXDEV))

    os.rename = refuse  # as the system does where the place is on another disk
    os.mkdir(sys.argv[1] + " moved")
    shutil.move(sys.argv[1], sys.argv[1] + " moved")
if "copy" in sys.argv:
    shutil.copytree(sys.argv[1], sys.argv[1] + " moved/out")
    shutil.rmtree(sys.argv[1])
"""
PROGRAMS = {"python": [], "usdsdg run": ["-m", "usdsdg", "run"]}


def run(program, script, *arguments):
    return forked.run([*PROGRAMS[program], str(script), *map(str, arguments)], cwd=ROOT)


def files_below(folder):
    return {each.relative_to(folder) for each in folder.rglob("*") if each.is_file()}


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The files that each program leaves where the folder stays as it is."""
    found = {}
    for program in PROGRAMS:
        folder = tmp_path_factory.mktemp("kept")
        (folder / "script.py").write_text(MOVED)
        done = run(program, folder / "script.py", folder / "out", "stay")
        assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
        found[program] = files_below(folder / "out")
    return found


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_temporary_folder_is_no_error_at_the_end(program, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = run(program, script)
    assert done.stdout.splitlines()[-1] == "removed"
    assert "error" not in done.stderr
    assert done.returncode == 0
    assert "usdsdg verify calls a copy of it unfinished" in done.stderr


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system does not tell where an open file was moved")
@pytest.mark.parametrize("program", PROGRAMS)
def test_a_folder_that_was_moved_is_the_dataset_that_stays(kept, program, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(MOVED)
    moved = tmp_path / "moved" / "out"
    done = run(program, script, moved, "move")
    assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
    assert not moved.exists()
    moved = moved.with_name("out moved")
    assert sorted(each.name for each in moved.iterdir()) == ["BasicWriter", "CocoWriter"]
    assert files_below(moved) == kept[program]
    verified = forked.run(["-m", "usdsdg", "verify", str(moved)], cwd=ROOT)
    assert verified.returncode == 0, verified.stdout
    assert verified.stdout.count("0 faults") == 2


@pytest.mark.skipif(sys.platform == "win32", reason="open files cannot be removed there")
@pytest.mark.parametrize(("program", "how"), [("python", "disk"), ("usdsdg run", "disk"), ("usdsdg run", "copy")])
def test_a_folder_that_was_moved_to_another_disk_is_the_dataset_that_stays(kept, program, how, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(MOVED)
    gone, moved = tmp_path / "gone/out", tmp_path / "gone/out moved/out"
    done = run(program, script, gone, how)
    assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
    assert not gone.exists()
    assert files_below(moved) == kept[program]
    recipe = Path("BasicWriter/.usdsdg/recipe.json")
    assert json.loads((moved / recipe).read_bytes())["frames"] == 2
    last = (moved / "CocoWriter/.usdsdg/journal.jsonl").read_text().splitlines()[-1]
    assert json.loads(last)["complete"]
    verified = forked.run(["-m", "usdsdg", "verify", "--files", str(moved)], cwd=ROOT)
    assert verified.returncode == 0, verified.stdout


AGAIN = """
import os
import shutil
import sys
import usdsdg as rep
out, how, writer_name = sys.argv[1:]
rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome")
product = rep.create.render_product(rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0)), (32, 24))
options = {"BasicWriter": {"rgb": True}, "CocoWriter": {"plain_names": True}}[writer_name]
for turn in range(3):
    if os.path.exists(out):
        if how == "remove":
            shutil.rmtree(out)
        else:
            os.rename(out, out + str(turn - 1))
    writer = rep.writers.get(writer_name, init_params={"output_dir": out, **options})
    writer.attach(product)
    for _ in range(turn + 1):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="open files cannot be removed there")
@pytest.mark.parametrize("writer", ["BasicWriter", "CocoWriter"])
@pytest.mark.parametrize(("program", "how"), [("usdsdg run", "remove"), ("usdsdg run", "move"), ("python", "remove")])
def test_a_folder_is_written_anew_where_the_script_has_removed_or_moved_it(program, how, writer, tmp_path):
    """Scripts clear their output folder before each of their scenes."""
    if how == "move" and not Path("/proc/self/fd").is_dir():
        pytest.skip("the system does not tell where an open file was moved")
    script = tmp_path / "script.py"
    script.write_text(AGAIN)
    done = run(program, script, tmp_path / "out", how, writer)
    assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
    assert "several writers" not in done.stderr
    assert "not there any more" not in done.stderr
    frames = {"out": 3, **({"out0": 1, "out1": 2} if how == "move" else {})}
    assert sorted(each.name for each in tmp_path.iterdir() if each.is_dir()) == sorted(frames)
    for name, count in frames.items():
        assert json.loads((tmp_path / name / ".usdsdg/recipe.json").read_bytes())["frames"] == count
        verified = forked.run(["-m", "usdsdg", "verify", str(tmp_path / name)], cwd=ROOT)
        assert "0 faults" in verified.stdout, verified.stdout
