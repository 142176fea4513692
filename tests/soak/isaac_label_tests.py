"""Run Isaac Sim's own tests of labels, unmodified, from a checkout of isaac-sim/IsaacSim.

`python -m tests.soak isaac_label_tests --checkout DIR [--only WORD]` prints a row per test. Each file runs in a process
of its own, with stand-ins for the test framework of Kit, and for ROS, whose messages its tests of boxes receive.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.soak import stand_in_assets
from tests.soak.isaac_tests import run_file

EXTENSIONS, DEPRECATED = "source/extensions", "source/deprecated"
CAMERA_TESTS = f"{DEPRECATED}/isaacsim.sensors.camera/isaacsim/sensors/camera/tests"

# File -> words of which the names of its tests have one; empty: all of them.
FILES: dict[str, tuple[str, ...]] = {
    f"{EXTENSIONS}/isaacsim.ros2.nodes/python/tests/test_bbox.py": (),
    f"{EXTENSIONS}/isaacsim.ros2.nodes/python/tests/test_semantic_labels.py": (),
    f"{EXTENSIONS}/isaacsim.replicator.examples/python/tests/test_sdg_geomsubset.py": (),
    f"{CAMERA_TESTS}/test_camera_sensor.py": ("annotators", "frame", "data_acquisition"),
    f"{EXTENSIONS}/isaacsim.core.experimental.utils/python/tests/test_semantics.py": (),
    f"{DEPRECATED}/isaacsim.core.utils/python/tests/test_semantics.py": (),
}


def main() -> int:
    options = _options()
    counts = {"passed": 0, "failed": 0}
    print("| test | result |\n|---|---|")
    with tempfile.TemporaryDirectory() as assets:
        root = stand_in_assets.overlay(options.assets_root or Path(assets) / "none", Path(assets) / "root")
        for file, words in FILES.items():
            if options.only not in file:
                continue
            for name, result in _run(options.checkout / file, words, root, options):
                counts["passed" if result == "passed" else "failed"] += 1
                print(f"| `{Path(file).stem}.{name}` | {result} |", flush=True)
    print(f"\n{counts['passed']} passed, {counts['failed']} failed")
    return int(counts["failed"] > 0 or not counts["passed"])


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkout", type=Path, required=True, help="a checkout of isaac-sim/IsaacSim 6.0.1")
    parser.add_argument("--assets-root", type=Path, help="Isaac Sim's assets; what it lacks is made by code")
    parser.add_argument("--only", default="", help="only files whose path contains this")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for one file")
    parser.add_argument("--device", default="cpu")
    options = parser.parse_args()
    options.checkout = options.checkout.resolve()
    return options


def _run(file: Path, words: tuple[str, ...], root: Path, options: argparse.Namespace) -> list[tuple[str, str]]:
    """Run the tests of a file; return the name of each and what came of it."""
    if not file.is_file():
        return [("*", f"there is no {file}")]
    command = [sys.executable, "-m", "usdsdg", "run", "--device", options.device, "--assets-root", str(root)]
    command += [run_file.__file__, str(file), *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=options.timeout, cwd=root)
    except subprocess.TimeoutExpired:
        return [("*", f"not ended after {options.timeout:.0f} s")]
    rows = [line.split("\t")[1:3] for line in done.stdout.splitlines() if line.startswith(run_file.ROW)]
    if not rows or (done.returncode and not any(result != "passed" for _, result in rows)):
        rows.append(["*", f"exit {done.returncode}: {(done.stderr or done.stdout)[-300:]}".replace("\n", " ")])
    return [(name, result.replace("|", "/")) for name, result in rows]


if __name__ == "__main__":
    sys.exit(main())
