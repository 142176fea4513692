"""Ctrl-C before the first frame ends the program soon, with exit code 130, during imports and compilation."""

import os
import signal
import subprocess
import sys
import time

import pytest

from tests.sampled_cases import sampled
from tests.signaled import started

PROGRAM = """
import signal, sys

class InterruptsAtImport:
    def find_spec(self, name, *_):
        if name == "MODULE":
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, InterruptsAtImport())
sys.argv = ["usdsdg", *sys.argv[1:]]
from usdsdg.cli.program import main
main()
"""


def usdsdg(*arguments: str, module: str, on_interrupt=signal.SIG_DFL) -> subprocess.CompletedProcess[str]:
    """Run the program and send it a Ctrl-C when it imports `module`."""
    return subprocess.run(
        [sys.executable, "-c", PROGRAM.replace("MODULE", module), *arguments],
        capture_output=True, text=True, timeout=60, preexec_fn=lambda: signal.signal(signal.SIGINT, on_interrupt),
    )  # fmt: skip


# The last two modules of pxr are imported by C++, which drops a KeyboardInterrupt in one and turns it into a
# TypeError in the other.
@pytest.mark.parametrize(
    "module", ["usdsdg.cli.app", "numpy", "click", "pxr.Sdf", "pxr.Kind", "pxr.Vt", "usdsdg.cli.commands.simulate"]
)
def test_an_interrupt_during_imports_ends_the_program_with_one_line(module):
    done = usdsdg("doctor", module=module)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_a_command_that_has_begun_finishes_its_files():
    done = usdsdg("doctor", module="warp")
    assert done.returncode == 130
    assert done.stderr.splitlines()[-1] == "files written so far are whole"


@pytest.mark.parametrize("command", ["verify", "inspect"])
def test_a_command_that_only_reads_has_no_files_to_finish(command, tmp_path):
    done = usdsdg(command, str(tmp_path), module=f"usdsdg.{command}.report")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_an_ignored_interrupt_stays_ignored():
    done = usdsdg("--version", module="numpy", on_interrupt=signal.SIG_IGN)
    assert done.returncode == 0
    assert done.stdout.startswith("usdsdg ")
    assert done.stderr == ""


SCENE = """#usda 1.0
def Sphere "ball" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] )
{
}
"""


@pytest.mark.parametrize(
    ("command", "label"), sampled([("render", "render kernels"), ("simulate", "compiling physics kernels")])
)
def test_an_interrupt_does_not_wait_for_compilers(command, label, tmp_path):
    (tmp_path / "scene.usda").write_text(SCENE)
    arguments = ["-m", "usdsdg", command, "scene.usda", "out.usda", "--device=cpu"]
    kernels = {"WARP_CACHE_PATH": str(tmp_path / "kernels")}
    with started(arguments, cwd=tmp_path, env=os.environ | kernels) as process:
        assert process.stderr is not None
        assert any(label in line for line in process.stderr)
        time.sleep(0.2)  # until a compiler is at work
        process.send_signal(signal.SIGINT)
        interrupted = time.monotonic()
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert stderr.splitlines()[-1] == "files written so far are whole"
    # Compiling takes at least five seconds.
    assert time.monotonic() - interrupted < 3
