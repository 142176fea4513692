"""A run whose output folder is removed meanwhile fails with one message, unless its dataset was done."""

from tests.cli.datasets import run
from usdsdg.verify import verify

SCRIPT = """
import shutil, sys
from pathlib import Path
import omni.replicator.core as rep
top = Path(sys.argv[1])
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
cube = rep.create.cube(semantics=[("class", "cube")])
product = rep.create.render_product(camera, (32, 24))
for name in ("CocoWriter", "VocWriter", "CvatWriter", "KittiWriter"):
    writer = rep.WriterRegistry.get(name)
    writer.initialize(output_dir=str(top / name))
    writer.attach(product)
rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
shutil.rmtree(top)
for _ in range(3):
    rep.orchestrator.step()
"""


def test_a_removed_output_folder_is_told_once(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = run(["-m", "usdsdg", "run", "-q", str(script), str(tmp_path / "out")], fresh=True)
    assert done.returncode == 1
    assert done.stderr.count("cannot be written") == 1, done.stderr
    assert "was removed" in done.stderr


DETACHED = """
import os, shutil, sys
import usdsdg as rep
from usdsdg.writers.journal import run
camera = rep.create.camera(position=(4, 4, 3), look_at=(0, 0, 0))
rep.create.cube(semantics=[("class", "cube")])
product = rep.create.render_product(camera, (16, 8))
for name in ("removed", "moved", "kept", "moved"):
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=f"{sys.argv[1]}/{name}", bounding_box_2d_tight=True)
    writer.attach(product)
    rep.orchestrator.step()
    if name == "kept":
        run.SECONDS = 0.0  # journals are appended to after each frame
        for _ in range(2):
            rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    writer.detach()
    if name == "removed":
        shutil.rmtree(f"{sys.argv[1]}/{name}")
    elif name == "moved" and not os.path.exists(f"{sys.argv[1]}/kept"):
        shutil.move(f"{sys.argv[1]}/{name}", f"{sys.argv[1]}/elsewhere")
"""


def test_a_dataset_that_is_done_may_be_removed_or_moved_while_others_are_made(tmp_path):
    (tmp_path / "script.py").write_text(DETACHED)
    done = run([str(tmp_path / "script.py"), str(tmp_path / "out")], fresh=True)
    assert done.returncode == 0, done.stderr
    assert "out/removed is not there any more" in done.stderr
    for name, frames in (("elsewhere", 1), ("kept", 3), ("moved", 1)):
        report = verify(tmp_path / "out" / name)
        assert (report.faults, report.recorded) == ([], frames)
