"""Datasets have the same bytes wherever their assets are, and are read where these are elsewhere."""

import gzip
import shutil
from pathlib import Path

import pytest

from tests import forked
from tests.cli.datasets import content

BOX = """#usda 1.0
(
    defaultPrim = "Box"
)
def Xform "Box"
{{
    def Cube "Body"
    {{
        double size = {size}
    }}
}}
"""
SCRIPT = """
import sys
import omni.replicator.core as rep
from isaacsim.storage.native import get_assets_root_path
boxes = [get_assets_root_path() + "/Isaac/box.usda", "parts/box.usda"]
rep.create.light(light_type="Dome")
first = rep.create.from_usd(boxes[0], semantics=[("class", "box")])
second = rep.create.from_usd(boxes[1], semantics=[("class", "part")], position=(0, 1, 0))
with rep.trigger.on_frame(), first:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
product = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True, semantic_segmentation=True)
writer.attach(product)
rep.settings.carb_settings("/app/assets", boxes[0])
rep.settings.carb_settings("/persistent/my/assets", sys.argv[2])
rep.orchestrator.run_until_complete(num_frames=2)
"""


class Machine:
    """A folder with assets, of which some are below the assets root and some beside the script."""

    def __init__(self, folder: Path, size: float = 1.0) -> None:
        self.folder, self.root = folder, folder / "assets"
        for file in (self.root / "Isaac/box.usda", folder / "work/parts/box.usda"):
            file.parent.mkdir(parents=True)
            file.write_text(BOX.format(size=size))
        (folder / "work/script.py").write_text(SCRIPT)

    def run(self, *arguments, fresh=False, inside="work"):
        command = ["-m", "usdsdg", arguments[0], "-q", "--device", "cpu", "--assets-root", str(self.root)]
        return forked.run([*command, *map(str, arguments[1:])], cwd=self.folder / inside, fresh=fresh)


@pytest.fixture(scope="module")
def machines(tmp_path_factory):
    """Two machines that have made the same dataset, each where it has its assets."""
    folder = tmp_path_factory.mktemp("machines")
    found = [Machine(folder / "alice"), Machine(folder / "home/of/bob")]
    for each in found:
        done = each.run("run", "script.py", each.folder / "out", each.root, fresh=True)
        assert done.returncode == 0, done.stderr
    return found


def test_datasets_have_the_same_bytes_wherever_their_assets_are(machines):
    alice, bob = (content(each.folder / "out") for each in machines)
    journals = [files.pop(".usdsdg/journal.jsonl").splitlines()[1:-1] for files in (alice, bob)]
    assert alice == bob
    assert journals[0] == journals[1]


def test_no_file_of_a_dataset_tells_where_its_assets_were(machines):
    for name, data in content(machines[0].folder / "out").items():
        assert b"alice" not in (gzip.decompress(data) if name.endswith(".gz") else data), name


def test_a_dataset_is_made_again_where_its_assets_are_elsewhere(machines):
    alice, bob = machines
    done = bob.run("reproduce", alice.folder / "out")
    assert done.returncode == 0, done.stderr + done.stdout
    assert ", 0 different" in done.stdout
    assert "other content" not in done.stderr


def test_frames_are_rendered_again_where_assets_are_elsewhere(machines):
    alice, bob = machines
    for each in machines:
        done = each.run("verify", "--render", alice.folder / "out")
        assert done.returncode == 0, done.stdout + done.stderr
        assert "2 rendered again" in done.stdout
    shutil.copytree(alice.folder / "out", bob.folder / "work/copies/out")
    done = bob.run("verify", "--render", "copies/out", inside="work")
    assert "2 rendered again" in done.stdout
    done = bob.run("verify", "--render", bob.folder / "work/copies/out", inside="assets")
    assert "2 rendered again" in done.stdout, "the folder of the dataset is in the working folder of the run"


def test_an_asset_with_other_content_is_named(machines, tmp_path):
    other = Machine(tmp_path / "other", size=1.5)
    (other.folder / "work/parts/box.usda").write_text(BOX.format(size=1.0))
    done = other.run("reproduce", machines[0].folder / "out")
    assert done.returncode == 1
    assert "note: the asset /Isaac/box.usda has other content than when" in done.stderr
    assert "parts" not in done.stderr
    assert "rgb_0000.png" in done.stdout
    done = other.run("verify", "--render", machines[0].folder / "out")
    assert (
        f"{other.root}/Isaac/box.usda is another file than that of the dataset, <assets>/Isaac/box.usda" in done.stdout
    )
    assert done.returncode == 0, "what is here says nothing of the dataset"


def test_an_asset_that_is_not_here_is_named(machines, tmp_path):
    other = Machine(tmp_path / "other")
    shutil.rmtree(other.folder / "work/parts")
    done = other.run("verify", "--render", machines[0].folder / "out")
    assert "frame 0 cannot be rendered again: <here>/parts/box.usda is not on this machine" in done.stdout


@pytest.fixture
def old(machines, tmp_path):
    """A dataset as records of version 2 have it: with the paths of its machine, and a stage named by those."""
    alice = machines[0]
    folder = Path(shutil.copytree(alice.folder / "out", tmp_path / "out"))
    (file,) = (folder / ".usdsdg/stages").iterdir()
    text = gzip.decompress(file.read_bytes()).decode()
    assert "@<assets>/Isaac/box.usda@" in text
    assert "@<here>/parts/box.usda@" in text
    text = text.replace("<assets>", str(alice.root)).replace("<here>", str(alice.folder / "work"))
    file.write_bytes(gzip.compress(text.encode()))
    recipe = folder / ".usdsdg/recipe.json"
    recipe.write_text(recipe.read_text().replace('"frame records": "3"', '"frame records": "2"'))
    return folder


def test_a_stage_with_the_paths_of_its_machine_is_read_as_before(machines, old):
    done = machines[1].run("verify", "--render", old)
    faults = [line for line in done.stdout.splitlines() if ": all frames: " in line]
    assert {line.split(": ")[0].split("/")[1] for line in faults} == {"stages", "recipe.json"}  # which were edited
    assert "2 faults" in done.stdout
    assert "2 rendered again" in done.stdout


def test_a_dataset_with_records_of_version_2_is_made_again(machines, old):
    """Its stages have other names, which are those of their bytes."""
    (file,), journal = (old / ".usdsdg/stages").iterdir(), old / ".usdsdg/journal.jsonl"
    file.rename(file.with_name("01234567.usda.gz"))
    journal.write_text(journal.read_text().replace(file.name, "01234567.usda.gz"))
    done = machines[0].run("reproduce", old)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'note: made with versions.frame records: "2", "3" now' in done.stderr
    assert "note: 2 files have other bytes and no tolerance" in done.stdout
