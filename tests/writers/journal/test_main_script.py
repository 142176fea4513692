"""What is kept of a script that Python runs, without a command."""

import hashlib
import json
import os
import subprocess
import sys

SCRIPT = """
import usdsdg as rep
from pathlib import Path
Path(__file__).write_text("edited = True\\n")
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=str(Path(__file__).parent / "out"), rgb=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0)), (16, 8)))
rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
"""


def test_a_script_that_is_edited_before_its_first_writer_is_kept_as_it_ran(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    subprocess.run(
        [sys.executable, script], cwd=tmp_path, check=True, env=os.environ | {"CUDA_VISIBLE_DEVICES": ""}, timeout=300
    )
    assert script.read_text() == "edited = True\n"
    assert (tmp_path / "out/.usdsdg/source/script.py").read_text() == SCRIPT
    recipe = json.loads((tmp_path / "out/.usdsdg/recipe.json").read_text())
    assert recipe["source"]["sha256"] == hashlib.sha256(SCRIPT.encode()).hexdigest()
