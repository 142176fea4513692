"""Actors of Ray: `python -m tests.soak ray` makes one dataset in several ways, and compares every byte.

One process; four actors on this machine; four of which two are killed while they work; two nodes of one cluster, with
a folder that both see, and with a bucket, also with two actors killed. The bucket is Ceph's where that is installed
(Debian's `ceph-mon ceph-osd ceph-common radosgw`), else moto's.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

from tests.cli.datasets import ROOT, content
from tests.soak import ceph
from tests.stores.servers import KEYS, Bucket

JOB = """
num_frames: {frames}
frames_per_episode: 5
num_cameras: 2
seed: 3
resolution: [64, 48]
path_tracing: {{every: 4, spp: 2, sub_frames: 2}}
labeled_assets_and_properties:
  - {{url: /Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd, label: pudding_box, count: 3, floating: true}}
  - {{url: /Isaac/Props/YCB/Axis_Aligned_Physics/006_mustard_bottle.usd, label: mustard, count: 3}}
shape_distractors_num: 4
writer_type: CocoWriter
writer_kwargs: {{output_dir: out, splits: {{train: 2, val: 1}}}}
"""


def start(job: Path, out: Path | str, *options: str) -> subprocess.Popen[bytes]:
    """Begin to make the dataset."""
    command = [sys.executable, "-m", "usdsdg", "generate", "-q", str(job), "--device", "cpu", "--threads", "1"]
    command += ["--set", f"writer_kwargs.output_dir={out}", *options]
    return subprocess.Popen(command, cwd=ROOT)


def kill_actors(process: subprocess.Popen[bytes], count: int, draw: random.Random) -> int:
    """Kill actors while they work; return how many were killed."""
    killed = 0
    while killed < count and process.poll() is None:
        time.sleep(draw.uniform(3.0, 6.0))
        found = subprocess.run(["pgrep", "-f", "ray::_Maker"], capture_output=True, text=True).stdout.split()
        if found:
            os.kill(int(draw.choice(found)), signal.SIGKILL)
            killed += 1
    return killed


def on_two_nodes(job: Path, out: str, meanwhile: Callable[[subprocess.Popen[bytes]], object]) -> int:
    """Make the dataset on a cluster of two nodes; return the exit code."""
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "include_dashboard": False})
    try:
        cluster.add_node(num_cpus=2)
        process = start(job, out, "--ray", cluster.address, "--workers", "4")
        meanwhile(process)
        return process.wait()
    finally:
        cluster.shutdown()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    draw = random.Random(options.seed)
    wrong = 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        job = folder / "job.yaml"
        job.write_text(JOB.format(frames=options.frames))
        if start(job, folder / "whole").wait():
            return 1

        def killed(out: Path) -> int:
            process = start(job, out, "--ray", "--workers", "4")
            print(f"{kill_actors(process, 2, draw)} actors killed")
            return process.wait()

        ways: dict[str, Callable[[Path], int]] = {
            "four actors": lambda out: start(job, out, "--ray", "--workers", "4").wait(),
            "two of four actors killed": killed,
            "two nodes": lambda out: on_two_nodes(job, str(out), lambda process: None),
        }
        for name, make in ways.items():
            started = time.monotonic()
            code = make(folder / "out")
            is_equal = not code and content(folder / "out") == content(folder / "whole")
            wrong += not is_equal
            said = "equal" if is_equal else f"not equal, exit code {code}"
            print(f"{name}: {said} ({time.monotonic() - started:.0f} s)", flush=True)
            shutil.rmtree(folder / "out", ignore_errors=True)
        with ceph.running() if ceph.is_installed() else nullcontext() as port:
            for name, count in (("two nodes and a bucket", 0), ("the same, two actors killed", 2)):
                bucket = Bucket(port)
                os.environ |= {**KEYS, "AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": bucket.url}
                started = time.monotonic()
                code = on_two_nodes(
                    job, f"s3://{bucket.name}/out", lambda process, n=count: kill_actors(process, n, draw)
                )
                made = {key.removeprefix("out/"): data for key, data in bucket.objects.items()}
                is_equal = not code and made == content(folder / "whole")
                wrong += not is_equal
                said = "equal" if is_equal else f"not equal, exit code {code}"
                print(f"{name}: {said} ({time.monotonic() - started:.0f} s)", flush=True)
    return int(wrong > 0)
