"""Processes that a script starts import the names of Omniverse as the script does."""

import ast
import os
import sys
from pathlib import Path

import pytest

from tests import forked
from tests.cli.datasets import run
from usdsdg.compat import children, finder
from usdsdg.session.script_processes import OPTIONS

POOLS = """
import multiprocessing, sys

def made(name):
    import carb
    import omni.replicator.core as rep
    from pxr import PhysxSchema
    assert PhysxSchema.PhysxRigidBodyAPI
    return str(rep.create.cube(name=name).get_output_prims()["prims"][0].GetPath())

if __name__ == "__main__":
    with multiprocessing.get_context(sys.argv[1]).Pool(1) as pool:
        print(pool.map(made, ["a", "b"]))
"""

LAUNCHER = """
import subprocess, sys
print(subprocess.run([sys.executable, *sys.argv[1:]], capture_output=True, text=True, check=True).stdout)
"""

CHILD = """
import sys
before = sorted(name for name in sys.modules if name.startswith(("usdsdg", "pxr", "numpy")))
from isaacsim import SimulationApp
app = SimulationApp({"headless": True})
import omni.usd
print(before, sys.argv[1:], omni.usd.get_context().get_stage().GetDefaultPrim().GetPath())
"""


def output(tmp_path, source, *arguments):
    script = tmp_path / "script.py"
    script.write_text(source)
    done = run(["-m", "usdsdg", "run", str(script), *arguments], fresh=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("method", ["spawn", *(["forkserver", "fork"] if sys.platform == "linux" else [])])
def test_workers_of_multiprocessing_import_them(tmp_path, method):
    assert "['/Replicator/a_Xform', '/Replicator/b_Xform']" in output(tmp_path, POOLS, method)


def test_a_launcher_starts_scripts_of_its_own(tmp_path):
    """Which load nothing of usdsdg before they import such a name."""
    (tmp_path / "child.py").write_text(CHILD)
    assert "[] ['--seed', '3'] /World" in output(tmp_path, LAUNCHER, str(tmp_path / "child.py"), "--seed", "3")


def test_a_launcher_runs_the_command_and_installs_the_names_itself(tmp_path):
    (tmp_path / "child.py").write_text(CHILD)
    assert "/World" in output(tmp_path, LAUNCHER, "-m", "usdsdg", "run", str(tmp_path / "child.py"))
    (tmp_path / "installing.py").write_text("import usdsdg.compat\nusdsdg.compat.install()\n" + CHILD)
    assert "/World" in output(tmp_path, LAUNCHER, str(tmp_path / "installing.py"))


def test_the_environments_own_start_is_run_in_children(tmp_path, monkeypatch):
    """Such as that which measures coverage."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own/sitecustomize.py").write_text("import sys\nsys.mark = 'of the environment'\n")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path / "own"), os.environ.get("PYTHONPATH", "")]))
    assert "of the environment" in output(tmp_path, LAUNCHER, "-c", "import sys; print(sys.mark)")


def test_a_name_that_nothing_has_is_missing_as_usual(tmp_path):
    code = "try:\n    import nowhere_at_all\nexcept ModuleNotFoundError as error:\n    print(error)"
    assert "No module named 'nowhere_at_all'" in output(tmp_path, LAUNCHER, "-c", code)


def test_a_run_leaves_the_environment_as_it_was(tmp_path, monkeypatch):
    from click.testing import CliRunner

    from usdsdg.cli.app import app

    monkeypatch.setenv("PYTHONPATH", "before")
    script = tmp_path / "script.py"
    script.write_text("import os\nassert os.environ['PYTHONPATH'].endswith('before')\n")
    assert CliRunner().invoke(app, ["run", str(script)]).exit_code == 0
    assert os.environ["PYTHONPATH"] == "before"


def test_the_names_of_children_are_those_of_the_script():
    """What runs at the start of each process has copies of them, since it must not import the finder."""
    source = Path(children.__file__).with_name("sitecustomize.py").read_text(encoding="utf-8")
    assigned = [each for each in ast.parse(source).body if isinstance(each, ast.Assign)]
    values = {each.targets[0].id: ast.literal_eval(each.value) for each in assigned}
    assert values["_ROOTS"] == (*finder.ROOTS, *finder.WEAK_ROOTS)
    assert set(values["_SCHEMAS"]) == {f"pxr.{name}" for name in finder.schemas()}


PROP = """
import multiprocessing, sys

def seen(_):
    import omni.replicator.core as rep
    from isaacsim.storage.native import get_assets_root_path
    import omni.usd
    rep.create.from_usd("omniverse://here/crate.usda")
    rep.create.from_usd(get_assets_root_path() + "/none.usda")
    stage = omni.usd.get_context().get_stage()
    names = [prim.GetName() for prim in stage.Traverse() if prim.GetTypeName() in ("Cube", "DistantLight")]
    from usdsdg.session import devices
    return get_assets_root_path(), names, devices.renderer_device()

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(pool.map(seen, [0]))
"""


def test_the_options_of_the_command_count_in_children(tmp_path):
    """Places of assets, what is missing, new stages and devices; here with a root that is relative."""
    (tmp_path / "root").mkdir()
    (tmp_path / "mapped").mkdir()
    (tmp_path / "mapped/crate.usda").write_text(
        '#usda 1.0\n(defaultPrim = "A")\ndef Xform "A"\n{\n    def Cube "crate"\n    {\n    }\n}\n'
    )
    script = tmp_path / "script.py"
    script.write_text(PROP)
    options = [
        "--assets-root", "root", "--map", "omniverse://here=mapped", "--missing-assets", "skip", "--new-stage", "kit",
        "--device", "cpu",
    ]  # fmt: skip
    done = forked.run(["-m", "usdsdg", "run", *options, str(script)], cwd=tmp_path, fresh=True)
    assert done.returncode == 0, done.stderr
    [(root, names, device)] = ast.literal_eval(done.stdout.splitlines()[-1])
    assert (root, sorted(names), device) == (str(tmp_path / "root"), ["crate", "defaultLight"], "cpu")


def test_options_are_told_again_by_processes_of_processes(tmp_path, monkeypatch):
    monkeypatch.delenv(OPTIONS, raising=False)
    (tmp_path / "root").mkdir()
    (tmp_path / "grandchild.py").write_text(
        "from isaacsim.storage.native import get_assets_root_path\nprint(get_assets_root_path())\n"
    )
    (tmp_path / "script.py").write_text(LAUNCHER)
    (tmp_path / "child.py").write_text("import carb\n" + LAUNCHER)
    command = ["-m", "usdsdg", "run", "--assets-root", str(tmp_path / "root"), str(tmp_path / "script.py")]
    done = run([*command, str(tmp_path / "child.py"), str(tmp_path / "grandchild.py")], fresh=True)
    assert done.returncode == 0, done.stderr
    assert str(tmp_path / "root") in done.stdout
    assert OPTIONS not in os.environ
