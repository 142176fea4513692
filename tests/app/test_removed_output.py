"""A script may remove its own output folder after its last file."""

import subprocess
import sys
from pathlib import Path

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


def test_a_temporary_folder_is_no_error_at_the_end(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, str(script)], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "removed"
    assert "error" not in done.stderr
    assert done.returncode == 0
