"""A run whose output folder is removed meanwhile fails with one message."""

from tests.cli.datasets import run

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
