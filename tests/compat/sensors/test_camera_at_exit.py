"""Cameras that live until Python ends: nothing is printed by their destructors."""

import subprocess
import sys

SCRIPT = """
from isaacsim import SimulationApp

app = SimulationApp({"headless": True})
from isaacsim.core.api import World
from isaacsim.sensors.camera import Camera

world = World()
camera = Camera(prim_path="/World/camera", position=[0, 0, 10.0], resolution=(8, 8))
world.reset()
camera.initialize()
"""


def test_a_camera_that_lives_until_the_end_says_nothing(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    run = subprocess.run(
        [sys.executable, "-m", "usdsdg", "run", "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0
    assert "Traceback" not in run.stderr
    assert "ignored" not in run.stderr
