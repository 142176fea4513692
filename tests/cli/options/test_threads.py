"""`--threads`: the pools of the process have no more threads, and files are the same."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.datasets import ROOT, content
from tests.sampled_cases import in_soak
from tests.scripts.conftest import usdsdg

SCRIPT = """
import json, os, sys, threading

import omni.replicator.core as rep
from pxr import Work

from usdsdg.parallel import available_threads

with rep.new_layer():
    rep.create.sphere(semantics=[("class", "ball")])
    rep.create.light(light_type="dome", intensity=500)
    product = rep.create.render_product(rep.create.camera(position=(0, -4, 1), look_at=(0, 0, 0)), (96, 64))
    writer = rep.WriterRegistry.get("BasicWriter")
    folder = os.path.abspath(sys.argv[1])
    writer.initialize(output_dir=folder, rgb=True, semantic_segmentation=True, bounding_box_2d_tight=True)
    writer.attach(product)
    with rep.trigger.on_frame(max_execs=2):
        pass
rep.orchestrator.run()
names = [thread.name for thread in threading.enumerate()]
print(json.dumps({
    "available": available_threads(), "usd": Work.GetConcurrencyLimit(), "omp": os.environ.get("OMP_NUM_THREADS"),
    "rendering": sum(name.startswith("usdsdg-") and name[7:].isdigit() for name in names),
    "writing": sum(name.startswith("usdsdg-io") for name in names),
}))
"""


@in_soak
def test_one_thread_bounds_all_pools_and_writes_the_same_files(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    bounded = usdsdg(
        "run", "--quiet", "--device", "cpu", "--threads", "1", "script.py", "one", cwd=tmp_path, fresh=True
    )
    told = json.loads(next(line for line in bounded.stdout.splitlines() if line.startswith("{")))
    assert told == {"available": 1, "usd": 1, "omp": "1", "rendering": 0, "writing": 1}
    usdsdg("run", "--quiet", "--device", "cpu", "script.py", "all", cwd=tmp_path, fresh=True)
    one, every = content(tmp_path / "one"), content(tmp_path / "all")
    assert "rgb_0001.png" in one
    assert one == every


LIMITED = """
import os

from usdsdg.cli import app
from usdsdg.cli.options.thread_limit import limit_threads

before = len(os.listdir("/proc/self/task"))
limit_threads(1)
import usdsdg.orchestrator
print(len(os.listdir("/proc/self/task")) - before)
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="the system lists no threads there")
def test_usd_starts_no_thread_where_there_may_be_one(tmp_path):
    # One that it had started before its limit would spin for the whole run.
    done = subprocess.run([sys.executable, "-c", LIMITED], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "0"


def test_no_thread_is_refused(tmp_path):
    done = usdsdg("generate", "--threads", "0", "x.yaml", cwd=tmp_path, expect=2)
    assert "--threads" in done.stderr
