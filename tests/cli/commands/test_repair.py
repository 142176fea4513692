"""`usdsdg repair` makes damaged files again with the bytes that the run wrote, and touches no others."""

import hashlib
import json
import os
import random
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.cli.datasets import content, run
from tests.sampled_cases import in_soak, sampled
from tests.verify import damage, damaged
from usdsdg.verify import verify

SCRIPT = """
import os, sys
import omni.replicator.core as rep
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
rep.create.light(light_type="dome")
cube, ball = rep.create.cube(semantics=[("class", "cube")]), rep.create.sphere(semantics=[("class", "ball")])
product = rep.create.render_product(camera, (32, 24))
for name, options in WRITERS.items():
    writer = rep.WriterRegistry.get(name)
    writer.initialize(output_dir=os.path.join(sys.argv[1], name), **options)
    writer.attach(product)
with rep.trigger.on_frame():
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
    with ball:
        rep.modify.visibility(rep.distribution.sequence([False, False, True, False, False]))
for frame in range(5):
    if frame == 3 and os.environ.get("ENDS_EARLY"):
        rep.orchestrator.wait_until_complete()
        raise KeyboardInterrupt
    rep.orchestrator.step()
"""
WRITERS = {
    "BasicWriter": {"rgb": True, "bounding_box_2d_tight": True},
    "BopWriter": {},
    "CocoWriter": {},
    "WebDatasetWriter": {"shard_samples": 2},
} | ({"ParquetWriter": {"shard_samples": 2}} if find_spec("pyarrow") else {})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder of datasets of one run, which was moved, and whose script is gone."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "script.py").write_text(f"WRITERS = {WRITERS}\n{SCRIPT}")
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", str(folder / "script.py"), str(folder / "out")]
    done = run(command, fresh=True)
    assert done.returncode == 0, done.stderr
    (folder / "script.py").unlink()
    return (folder / "out").rename(folder / "moved")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A dataset of one writer."""
    return damaged.make(tmp_path_factory.mktemp("small"), 6)


@pytest.fixture
def out(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "out")


def repair(folder, *options):
    return run(["-m", "usdsdg", "repair", "-q", str(folder), "--device", "cpu", *options])


def flip(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)


def identities(folder: Path) -> dict[str, tuple[int, int]]:
    files = (path for path in folder.rglob("*") if not path.is_dir())
    return {path.relative_to(folder).as_posix(): (path.lstat().st_ino, path.lstat().st_mtime_ns) for path in files}


def listed(dataset: Path, *, frame: int) -> dict[str, list]:
    lines = map(json.loads, (dataset / ".usdsdg/journal.jsonl").read_text().splitlines())
    return next(line["files"] for line in lines if line.get("frame") == frame)


def test_every_kind_of_damage_is_repaired_and_nothing_else_is_touched(whole, out):
    basic, coco, tars = out / "BasicWriter", out / "CocoWriter", out / "WebDatasetWriter"
    os.truncate(basic / "rgb_0001.png", 50)
    flip(basic / "bounding_box_2d_tight_0001.npy")
    (basic / ".usdsdg/frames/000001.npz").write_bytes(b"")
    shutil.copy(basic / "rgb_0002.png", basic / "rgb_0003.png")
    (basic / "metadata.txt").unlink()
    shutil.rmtree(basic / ".usdsdg/source")  # which the other datasets of the run have, too
    shutil.rmtree(basic / ".usdsdg/stages")
    pictures = next(path.parent for path in coco.rglob("*.png"))
    shutil.rmtree(pictures)
    tables = [path for path in coco.rglob("*.json") if ".usdsdg" not in path.parts]
    assert tables
    for path in tables:
        path.write_bytes(path.read_bytes()[:-9])
    flip(tars / "train-000001.tar")
    (tars / "index.json").unlink()
    (tars / "train-000000.tar").rename(out.parent / "linked.tar")
    (tars / "train-000000.tar").symlink_to(out.parent / "linked.tar")
    for path in out.glob("ParquetWriter/data/train-00001.parquet"):
        os.truncate(path, 100)
    before, damaged = identities(out), content(out)
    dry = repair(out, "--dry-run")
    assert dry.returncode == 0, dry.stdout + dry.stderr
    assert f"{tars}: 3 damaged files; frames 0-3 would be made again; 1 file would be made again of the " in dry.stdout
    assert "rgb_0001.png: frame 1: its size is not the one in the journal" in dry.stdout
    assert identities(out) == before
    done = repair(out)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{out / 'BopWriter'}: no file is damaged" in done.stdout
    assert f"{basic}: 7 files repaired, 0 left; frames 0-1, 3-4 made again" in done.stdout
    assert content(out) == content(whole)
    after, wanted = identities(out), content(whole)
    was_link = {"WebDatasetWriter/train-000000.tar"}
    untouched = {name for name, data in damaged.items() if data == wanted[name]} - was_link
    assert {name for name in before if after[name] == before[name]} == untouched
    assert not (tars / "train-000000.tar").is_symlink()
    again = repair(out)
    assert again.stdout.count("no file is damaged") == len(WRITERS)
    assert not again.returncode
    assert identities(out) == after


def test_what_only_all_frames_make_is_made_of_all(whole, out):
    bop, coco = out / "BopWriter", out / "CocoWriter"
    models = sorted((bop / "models").glob("*.ply"))
    assert len(models) == 2
    models[0].unlink()
    models[1].unlink()
    done = repair(out)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "which the first and the last one do not make" in done.stderr
    assert f"{bop}: 2 files repaired, 0 left; all frames made again, for models/" in done.stdout
    next((coco / ".usdsdg/aggregates").rglob("*.jsonl")).unlink()
    done = repair(coco)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1 file repaired, 0 left; all frames made again, for .usdsdg/aggregates/" in done.stdout
    assert content(out) == content(whole)


def test_what_cannot_be_repaired_is_named(whole, out):
    basic = out / "BasicWriter"
    (basic / "rgb_0000.png").unlink()
    (basic / "rgb_0000.png").mkdir()
    (basic / "notes.txt").write_text("mine")
    flip(basic / "rgb_0004.png")
    done = repair(basic, "--json")
    assert done.returncode == 1
    values = json.loads(done.stdout)
    assert values["repaired"] == ["rgb_0004.png"]
    assert values["frames"] == [0, 4]
    assert [(each["file"], each["what"]) for each in values["left"]] == [
        ("rgb_0000.png", "has a folder in its place; remove that"),
        ("notes.txt", "no run wrote it; it is left, remove it if nothing needs it"),
    ]
    assert (basic / "rgb_0000.png").is_dir()
    shutil.rmtree(basic / ".usdsdg/source")
    (basic / "rgb_0000.png").rmdir()
    done = repair(basic)
    assert done.returncode == 1
    assert "script.py; give the file that made it with --source" in done.stderr
    assert "rgb_0000.png: frame 0: was not made again" in done.stdout
    assert f"{basic}: 0 files repaired, 2 left, 1 that no run wrote" in done.stdout


def test_other_versions_are_tried_only_where_the_user_says_so(whole, out):
    coco = out / "CocoWriter"
    recipe, journal = coco / ".usdsdg/recipe.json", coco / ".usdsdg/journal.jsonl"
    recipe.write_text(recipe.read_text().replace('"warp-lang": "', '"warp-lang": "0.'))
    *lines, closing = journal.read_text().splitlines()
    sealed = json.loads(closing) | {"recipe": hashlib.sha256(recipe.read_bytes()).hexdigest()}
    journal.write_text("\n".join([*lines, json.dumps(sealed, separators=(",", ":"))]) + "\n")
    table = next(path for path in coco.rglob("*.json") if ".usdsdg" not in path.parts)
    picture = next(coco.rglob("*.png"))
    table.unlink()
    picture.unlink()
    done = repair(coco)
    assert done.returncode == 1
    assert "was made with versions.warp-lang" in done.stderr
    assert "--anyway tries" in done.stderr
    assert f"{picture.name}: frame" in done.stdout
    assert table.exists()  # which takes no frames
    done = repair(coco, "--anyway")
    assert done.returncode == 0, done.stdout + done.stderr
    assert picture.read_bytes() == (whole / picture.relative_to(out)).read_bytes()


def test_an_interrupted_repair_keeps_what_it_has_and_the_next_one_goes_on(whole, out, monkeypatch):
    basic = out / "BasicWriter"
    pictures = sorted(basic.glob("*.png"))
    for path in pictures:
        path.unlink()
    monkeypatch.setenv("ENDS_EARLY", "yes")
    done = repair(basic)
    assert done.returncode == 130
    assert done.stdout == f"{basic}: 3 files repaired, 2 left\n"
    assert [path for path in pictures if path.exists()] == pictures[:3]
    (basic / ".rgb_0003.png.1-0.part").write_bytes(b"of a process that died")
    monkeypatch.delenv("ENDS_EARLY")
    before = identities(basic)
    done = repair(basic)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{basic}: 2 files repaired, 0 left; frames 3-4 made again" in done.stdout
    assert content(basic) == content(whole / "BasicWriter")
    assert before.items() - identities(basic).items() == {(".rgb_0003.png.1-0.part", before[".rgb_0003.png.1-0.part"])}


TWO_FRAMES = """
import os, sys
os.environ["CUDA_VISIBLE_DEVICES"] = ""  # pictures are repaired on the CPU
import usdsdg as rep
rep.create.light(light_type="dome")
rep.create.cube()
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24)))
for _ in range(2):
    rep.orchestrator.step()
exec(os.environ.get(f"ENDING_{sys.argv[2]}", ""))
rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
"""


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory):
    """A folder with datasets of two runs, `one` by plain Python and `two` by `usdsdg run`."""
    folder = tmp_path_factory.mktemp("two_runs")
    (folder / "script.py").write_text(TWO_FRAMES)
    for name, command in (("one", []), ("two", ["-m", "usdsdg", "run", "-q", "--device", "cpu"])):
        done = run([*command, str(folder / "script.py"), str(folder / "out" / name), name], fresh=True)
        assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.mark.parametrize(
    ("failing", "ending", "told"),
    sampled(
        [
            ("one", "sys.exit(3)", "exit code 3"),
            ("one", "raise ValueError('mine')", "exit code 1"),
            ("two", "raise ValueError('mine')", "exit code 1"),
            ("two", "sys.exit(3)", "exit code 3"),
        ],
        2,
    ),
)
def test_a_script_that_ends_early_leaves_the_other_datasets_to_be_repaired(
    two_runs, tmp_path, monkeypatch, failing, ending, told
):
    out = shutil.copytree(two_runs, tmp_path / "out")
    pictures = sorted(out.rglob("*.png"))
    assert len(pictures) == 6
    for path in pictures:
        path.unlink()
    monkeypatch.setenv(f"ENDING_{failing}", ending)
    done = repair(out)
    assert done.returncode == 1, done.stdout + done.stderr
    assert f"script.py ended with {told}" in done.stderr
    assert ("ValueError: mine" in done.stderr) == ("ValueError" in ending)
    assert done.stderr.endswith(f"error: not repaired, for the reasons above: {out / failing}\n")
    assert f"{out / failing}: 2 files repaired, 1 left\n" in done.stdout
    other = "two" if failing == "one" else "one"
    assert f"{out / other}: 3 files repaired, 0 left; frames 0-2 made again\n" in done.stdout
    monkeypatch.delenv(f"ENDING_{failing}")
    assert repair(out).returncode == 0
    assert content(out) == content(two_runs)


ERRORS = {
    "of usdsdg": ("from usdsdg.errors import StageError\nraise StageError('no such stage')", "error: no such stage\n"),
    "of pxr": ("from pxr import Tf\nTf.RaiseRuntimeError('damaged value')", "USD cannot read: "),
    "of ours": ("raise KeyError('forgotten')", "KeyError: 'forgotten'\n"),
}
# Makes what is made by `usdsdg run` fail, as a configuration may.
FAILING = """
from usdsdg.cli import made_again
def fail(*given):
    FAILURE
made_again._run = fail
from usdsdg.cli.program import main
main()
"""


@pytest.mark.parametrize("command", ["repair", "reproduce"])
@pytest.mark.parametrize("kind", ERRORS)
def test_an_error_of_one_run_leaves_the_other_datasets_to_be_made(two_runs, tmp_path, command, kind):
    out = shutil.copytree(two_runs, tmp_path / "out")
    if command == "repair":
        for path in sorted(out.rglob("*.png")):
            path.unlink()
    failing, (failure, told) = out / "of a run", ERRORS[kind]
    (out / "two").rename(failing)  # which comes first
    program = FAILING.replace("FAILURE", failure.replace("\n", "\n    "))
    done = run(["-c", program, command, "-q", "--device", "cpu", str(out)])
    assert done.returncode == 1, done.stdout + done.stderr
    assert told in done.stderr
    assert ("Traceback" in done.stderr) == (kind == "of ours")
    done_what = "repaired" if command == "repair" else "compared"
    assert done.stderr.endswith(f"error: not {done_what}, for the reasons above: {failing}\n")
    good = "3 files repaired, 0 left; frames 0-2 made again" if command == "repair" else "files equal, 0 different"
    (line,) = [line for line in done.stdout.splitlines() if line.startswith(f"{out / 'one'}: ")]
    assert good in line


def test_a_damaged_recipe_leaves_the_other_datasets_to_be_compared(two_runs, tmp_path):
    out = shutil.copytree(two_runs, tmp_path / "out")
    (out / "one/.usdsdg/recipe.json").write_text("{")
    done = run(["-m", "usdsdg", "reproduce", "-q", "--device", "cpu", str(out)])
    assert done.returncode == 1
    assert done.stderr.endswith(f"error: not compared, for the reasons above: {out / 'one'}\n")
    assert f"{out / 'two'}: " in done.stdout


@pytest.mark.parametrize("command", ["repair", "reproduce"])
def test_assets_that_have_moved_are_found_with_a_map(tmp_path, command):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/box.usda").write_text('#usda 1.0\n( defaultPrim = "A" )\ndef Cube "A" {}\n')
    script = tmp_path / "script.py"
    script.write_text(TWO_FRAMES.replace("rep.create.cube()", "rep.create.from_usd('omniverse://host/P/box.usda')"))
    options, out = ["--device", "cpu", "--map", f"omniverse://host/P={tmp_path / 'mine'}"], tmp_path / "out"
    done = run(["-m", "usdsdg", "run", "-q", *options, str(script), str(out), "one"])
    assert done.returncode == 0, done.stderr
    next(out.glob("rgb*.png")).unlink()
    again = ["-m", "usdsdg", command, "-q", str(out)]
    done = run([*again, "--device", "cpu"])
    assert done.returncode == 1
    assert "--map PREFIX=FOLDER" in done.stderr
    assert "--missing-assets" not in done.stderr  # which would make other frames
    done = run([*again, *options])
    assert done.returncode == (command == "reproduce"), done.stdout + done.stderr
    assert {"repair": "1 file repaired, 0 left", "reproduce": "1 different"}[command] in done.stdout


def test_a_file_that_is_made_otherwise_stays_as_it_is(whole, out):
    """As where the journal tells of other bytes than this machine makes."""
    basic = out / "BasicWriter"
    journal = basic / ".usdsdg/journal.jsonl"
    (size, sha256), picture = listed(basic, frame=2)["rgb_0002.png"], basic / "rgb_0002.png"
    *lines, closing = journal.read_text().replace(sha256, sha256[::-1]).splitlines(keepends=True)
    sealed = json.loads(closing) | {"lines": hashlib.sha256("".join(lines).encode()).hexdigest()}
    journal.write_text("".join(lines) + json.dumps(sealed, separators=(",", ":")) + "\n")
    before = identities(basic)
    done = repair(basic)
    assert done.returncode == 1
    assert "rgb_0002.png: frame 2: is made with other bytes than the run wrote" in done.stdout
    assert f"{basic}: 0 files repaired, 1 left; frame 2 made again" in done.stdout
    assert identities(basic) == before
    assert picture.stat().st_size == size


@in_soak
def test_a_dataset_of_several_processes_that_has_grown_is_repaired(tmp_path):
    (tmp_path / "job.yaml").write_text(
        "job: detection\noutput_dir: out\nformats: {yolo: {}, webdataset: {shard_samples: 2}}\nresolution: [32, 32]\n"
        "num_frames: 3\n"
    )
    command = ["-m", "usdsdg", "generate", "-q", str(tmp_path / "job.yaml"), "--device", "cpu", "--workers", "2"]
    command += ["--set", f"output_dir={tmp_path / 'out'}"]
    for options in ((), ("--resume", "--set", "num_frames=5")):
        done = run([*command, *options], fresh=True)
        assert done.returncode == 0, done.stderr
    whole = content(tmp_path / "out")
    shutil.rmtree(tmp_path / "out/yolo/images")
    (tmp_path / "out/yolo/data.yaml").unlink()
    flip(next((tmp_path / "out").rglob("*.tar")))
    done = repair(tmp_path / "out")
    assert done.returncode == 0, done.stdout + done.stderr
    assert content(tmp_path / "out") == whole


@in_soak
@pytest.mark.parametrize("kind", damage.KINDS)
def test_every_damage_that_is_found_is_repaired_or_named(small, tmp_path, kind):
    out = shutil.copytree(small, tmp_path / "out")
    expected = damage.KINDS[kind](out, random.Random(1))
    before = identities(out)
    done = repair(out)
    left = {fault.file for fault in verify(out, labels=False).faults}
    assert (done.returncode == 0) == (left == set()), done.stdout + done.stderr
    assert left <= expected
    if lost := left & {damage.JOURNAL, damage.RECIPE}:  # without which nothing is repaired
        assert str(out) in done.stderr
        assert "has not ended" in done.stderr or any(name in done.stderr for name in lost)
    else:
        assert all(f"{name}: " in done.stdout for name in left)
    after = identities(out)
    assert {name for name in before if after.get(name) != before[name]} <= expected
    if not left:
        assert content(out) == content(small)


def test_json_names_a_dataset_of_a_folder_that_cannot_be_repaired(out):
    (out / "BasicWriter/.usdsdg/recipe.json").unlink()
    done = repair(out, "--json", "--dry-run")
    assert done.returncode == 1
    values = json.loads(done.stdout)
    assert (values["folder"], values["clean"]) == (str(out), False)
    assert values["failed"] == [str(out / "BasicWriter")]
    assert sorted(each["folder"] for each in values["datasets"]) == sorted(
        str(each) for each in out.iterdir() if each.is_dir() and each.name != "BasicWriter"
    )
