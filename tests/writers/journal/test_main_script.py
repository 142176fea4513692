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


PARTS = """
import sys
import usdsdg as rep

for name in "ab":
    rep.new_stage()
    rep.create.from_usd(f"{sys.argv[1]}/{name}.obj", semantics=[("class", "part")])
    product = rep.create.render_product(rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0)), (16, 8))
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=f"{sys.argv[1]}/out_{name}", rgb=True)
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
"""


def test_the_recipe_names_mesh_files_that_were_read_before_there_was_a_writer(tmp_path):
    (tmp_path / "script.py").write_text(PARTS)
    for name in "ab":
        (tmp_path / f"{name}.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 {ord(name)} 1\nf 1 2 3\n")
    command = [sys.executable, "script.py", str(tmp_path)]
    subprocess.run(command, cwd=tmp_path, check=True, env=os.environ | {"CUDA_VISIBLE_DEVICES": ""}, timeout=300)
    recipe = json.loads((tmp_path / "out_a/.usdsdg/recipe.json").read_text())
    assert {"name": "a.obj", "path": "a.obj"}.items() <= recipe["assets"][0].items()
    recipe = json.loads((tmp_path / "out_b/.usdsdg/recipe.json").read_text())
    assert "b.obj" in [each["name"] for each in recipe["assets"]]
