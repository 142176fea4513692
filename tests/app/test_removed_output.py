"""A script may remove or move its own output folder after its last file."""

import subprocess
import sys
from pathlib import Path

import pytest

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
import os
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
"""
PROGRAMS = {"python": [sys.executable], "usdsdg run": [sys.executable, "-m", "usdsdg", "run"]}


def run(program, script, *arguments):
    command = [*PROGRAMS[program], str(script), *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)


def files_below(folder):
    return {each.relative_to(folder): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


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
def test_a_folder_that_was_moved_is_the_dataset_that_stays(program, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(MOVED)
    kept, moved = tmp_path / "kept" / "out", tmp_path / "moved" / "out"
    for folder, *words in ((kept, "stay"), (moved, "move")):
        done = run(program, script, folder, *words)
        assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr
    assert not moved.exists()
    moved = moved.with_name("out moved")
    assert sorted(each.name for each in moved.iterdir()) == ["BasicWriter", "CocoWriter"]
    assert files_below(kept).keys() == files_below(moved).keys()
    verified = subprocess.run(
        [sys.executable, "-m", "usdsdg", "verify", str(moved)], cwd=ROOT, capture_output=True, text=True, timeout=120
    )
    assert verified.returncode == 0, verified.stdout
    assert verified.stdout.count("0 faults") == 2
