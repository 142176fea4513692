"""Warp starts without its line about a driver where there is neither a driver nor a GPU; all other lines are kept."""

import subprocess
import sys

import pytest

from tests import forked
from usdsdg import warp_start

SCRIPT = """
import os
from usdsdg import warp_start
with warp_start._lines_held_back(b"about the driver"):
    os.write(2, b"before\\nabout the driver: none\\n")
    print("text", file=__import__("sys").stderr)
os.write(2, b"after\\n")
"""


def error_of(script: str) -> str:
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stderr


def test_only_the_line_that_is_meant_is_left_out():
    assert error_of(SCRIPT).splitlines() == ["before", "text", "after"]


@pytest.mark.skipif(warp_start.has_cuda_driver() or warp_start.has_nvidia_gpu(), reason="needs a machine without GPU")
def test_warp_says_nothing_where_there_is_no_gpu():
    assert error_of("from usdsdg.warp_start import quiet_warp; quiet_warp(); import warp; warp.init()") == ""


@pytest.mark.skipif(warp_start.has_cuda_driver() or warp_start.has_nvidia_gpu(), reason="needs a machine without GPU")
@pytest.mark.parametrize(
    "use",
    [
        "from isaacsim.core.experimental.prims import XformPrim; XformPrim('/World').get_world_poses()",
        "from isaacsim.core.experimental.objects import Cube; Cube('/World/c', sizes=1.0, positions=[0, 0, 1])",
        "from isaacsim.core.experimental.utils import ops; ops.place([1.0, 2.0]); ops.parse_device(None)",
        "from isaacsim.core.simulation_manager import SimulationManager as m; m.set_device('cpu'); m.get_device()",
        "import omni.replicator.core as rep; rep.annotators.get('rgb', device='cpu')",
        "from pxr import Usd; import usdsdg_render.renderer as r; r.WarpRenderer(Usd.Stage.CreateInMemory()).sync()",
    ],
)
def test_wrappers_whose_arrays_are_warps_start_it_without_a_word(use):
    script = f"import usdsdg.compat; usdsdg.compat.install()\n{use}"
    done = forked.run(["-c", script], cwd=forked.ROOT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_gpu_without_a_driver_keeps_the_line(monkeypatch):
    monkeypatch.setattr(warp_start, "has_cuda_driver", lambda: False)
    monkeypatch.setattr(warp_start, "has_nvidia_gpu", lambda: True)
    monkeypatch.setattr(warp_start, "start_warp", lambda: pytest.fail("it is left to Warp"))
    warp_start._start_without_driver.__wrapped__()


def test_where_standard_error_is_closed_nothing_is_held_back():
    error_of("import os; os.close(2)\nfrom usdsdg import warp_start\nwith warp_start._lines_held_back(b'x'): pass")


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of the system")
def test_without_a_folder_of_temporary_files_nothing_is_held_back():
    no_files = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"  # as on a full disk
    assert error_of(no_files + SCRIPT).splitlines() == ["before", "about the driver: none", "text", "after"]


@pytest.mark.skipif(warp_start.has_cuda_driver() or warp_start.has_nvidia_gpu(), reason="needs a machine without GPU")
def test_a_gpu_that_is_asked_for_and_not_there_is_one_error():
    script = "from usdsdg.session.devices import use_device\ntry:\n    use_device('cuda')\nexcept Exception as error:\n"
    done = forked.run(["-c", f"{script}    print(error)"], cwd=forked.ROOT)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["cannot render on 'cuda': no GPU can be used. Devices here: cpu."]
