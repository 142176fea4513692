"""`usdsdg run --workers N`: several processes make the frames of a script, and leave what one leaves."""

import pytest

from tests.cli.datasets import content, run
from tests.verify.damaged import SCRIPT

FRAMES = 5
# Leaves its folder, counts its runs, says something, and writes with a second writer whose folder has a number.
LONGER = (
    "import os\nprint('said by the script')\nopen(sys.argv[3], 'a').write('run ')\n"
    'coco = rep.WriterRegistry.get("CocoWriter")\n'
    'coco.initialize(output_dir=sys.argv[2] + "_coco")\n'
    "coco.attach(rep.create.render_product(camera, (48, 32)))\n"
    "os.chdir('/')\n"
)


def script(folder, before_run=LONGER):
    file = folder / "script.py"
    file.write_text(SCRIPT.replace("rep.orchestrator.run()", before_run + "rep.orchestrator.run()\nsys.exit(0)"))
    return file


def usdsdg_run(file, *options, arguments=(), fresh=False):
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--seed", "5", *options]
    return run([*command, str(file), *arguments], fresh=fresh)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    arguments = (str(FRAMES), str(folder / "out"), str(folder / "runs"))
    done = usdsdg_run(script(folder), arguments=arguments, fresh=True)
    assert done.returncode == 0, done.stderr
    return {name: content(folder / name) for name in ("out", "out_coco")}


def same(found, expected):
    """Whether datasets are equal, apart from the arguments that say where they are."""
    skipped = (".usdsdg/recipe.json", ".usdsdg/journal.jsonl")
    return {name: data for name, data in found.items() if name not in skipped} == {
        name: data for name, data in expected.items() if name not in skipped
    }


def test_three_processes_leave_the_files_of_one_and_an_earlier_run_is_replaced(whole, tmp_path):
    arguments = (str(FRAMES), str(tmp_path / "out"), str(tmp_path / "runs"))
    done = usdsdg_run(script(tmp_path), "--workers", "3", arguments=arguments)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("said by the script") == 1
    assert "nothing" not in done.stderr
    assert (tmp_path / "runs").read_text() == "run " * 4
    for name, files in whole.items():
        found = content(tmp_path / name)
        assert same(found, files), sorted(found.keys() ^ files.keys())
    verified = run(["-m", "usdsdg", "verify", "--files", str(tmp_path / "out")])
    assert verified.returncode == 0, verified.stdout
    before = content(tmp_path / "out")
    (tmp_path / "out" / "rgb_0002.png").unlink()
    again = usdsdg_run(script(tmp_path), "--workers", "2", arguments=arguments)
    assert "the files of the earlier run there are replaced" in again.stderr
    assert content(tmp_path / "out") == before


def test_what_cannot_be_shared_out_is_told(tmp_path):
    file = tmp_path / "script.py"
    file.write_text("import omni.replicator.core as rep\nrep.create.cube()\n")
    done = usdsdg_run(file, "--workers", "2")
    assert done.returncode == 1
    assert "so there is nothing to be shared out" in done.stderr
    done = usdsdg_run(file, "--workers", "2", "--shard", "0/2")
    assert done.returncode == 1
    assert "--workers makes all frames" in done.stderr


def test_an_error_in_a_process_is_that_of_the_command(tmp_path):
    fails = "if os.path.exists(sys.argv[3]):\n    raise RuntimeError('only the first time')\n"
    before = "import os\n" + fails + LONGER
    arguments = ("2", str(tmp_path / "out"), str(tmp_path / "runs"))
    done = usdsdg_run(script(tmp_path, before), "--workers", "2", arguments=arguments)
    assert done.returncode == 1
    assert "ended with exit code 1" in done.stderr
    assert "only the first time" in done.stderr


def test_progress_lines_tell_what_was_made(tmp_path):
    """Frames that the first process counts are not captured, and those that are whole already are not made."""
    arguments = (str(FRAMES), str(tmp_path / "out"), str(tmp_path / "runs"))
    command = ["-m", "usdsdg", "run", "--device", "cpu", "--workers", "2"]
    done = run([*command, str(script(tmp_path)), *arguments])
    assert done.returncode == 0, done.stderr
    made = done.stderr.index(f"[usdsdg] {FRAMES} frames are made by 2 processes")
    assert "frames captured" not in done.stderr[:made]
    *before, last = [line for line in done.stderr[made:].splitlines() if "frames captured" in line]
    assert last.startswith(f"[usdsdg] frames captured: {FRAMES}/{FRAMES}")
    assert not any(f"{FRAMES}/{FRAMES}" in line for line in before)
    again = run([*command, "--resume", str(script(tmp_path)), *arguments])
    assert again.returncode == 0, again.stderr
    assert f"has {FRAMES} frames, which are not made again" in again.stderr
    assert "are made by" not in again.stderr
    assert "frames captured" not in again.stderr
