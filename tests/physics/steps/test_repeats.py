"""The same stage gives the same bits in another process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from newton._src.geometry import narrow_phase

from tests.physics.scenes import add, new_stage, playing

SCRIPT = """
import hashlib
import numpy as np
from tests.physics.scenes import add, new_stage, playing
stage = new_stage()
add(stage, "/World/ground", at=(0, 0, -0.1), scale=(2, 2, 0.1), body=False)
rng = np.random.default_rng(0)
kinds = ["Cube", "Sphere", "Capsule", "Cone", "Cylinder"]
for i in range(40):
    at, turn = rng.uniform(-0.3, 0.3, 3) + (0, 0, 0.6), rng.uniform(0, 360, 3)
    add(stage, f"/World/b{i}", kinds[i % 5], at=tuple(at), rotate=tuple(turn), gravity=i % 4 > 0)
engine = playing(stage)
for _ in range(90):
    engine.advance(1 / 60)
    engine.overlap_box((1, 1, 0.1), (0, 0, 0.1))
print(hashlib.sha256(stage.GetRootLayer().ExportToString().encode()).hexdigest())
"""


def test_two_processes_write_the_same_stage():
    root = Path(__file__).resolve().parents[3]
    runs = [
        subprocess.Popen([sys.executable, "-c", SCRIPT], cwd=root, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(2)
    ]
    outputs = [run.communicate(timeout=200) for run in runs]
    assert all(run.returncode == 0 for run in runs), outputs
    digests = [output.decode().split()[-1] for output, _ in outputs]
    assert len(digests[0]) == 64
    assert digests[0] == digests[1]


def test_pipelines_share_kernels_and_newton_keeps_its_functions():
    made = vars(narrow_phase)["create_narrow_phase_primitive_kernel"]
    kernels = []
    for kind in ("Cube", "Sphere"):
        stage = new_stage()
        add(stage, "/World/body", kind)
        engine = playing(stage)
        engine.advance(1 / 60)
        session = engine._session
        assert session is not None
        assert session.world is not None
        kernels.append(session.world.pipeline.narrow_phase.narrow_phase_kernel)
    assert kernels[0] is kernels[1]
    assert vars(narrow_phase)["create_narrow_phase_primitive_kernel"] is made
