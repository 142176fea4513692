"""Run Isaac Sim's in-scope Replicator scripts, unmodified, from a checkout of isaac-sim/IsaacSim.

`python -m tests.soak isaac_scripts --checkout DIR --assets-root DIR [--only WORD]` prints a row per run. A run passes
if the script comes to its end, with its own validation where it has one (`--test`), and exits with code 0.
Assets that the root lacks are made by code.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from tests.soak import stand_in_assets

EXAMPLES = "api/isaacsim.replicator.examples"
OBJECTS, SCENES = "replicator/object_based_sdg", "replicator/scene_based_sdg"
FEW_FRAMES = ("--num-frames", "3", "--resolution", "320", "240")

# Script -> the arguments of each of its runs; the sizes of benchmarks are reduced by their own options.
SCRIPTS: dict[str, list[tuple[str, ...]]] = {
    **{
        f"{EXAMPLES}/{name}.py": [("--test",)]
        for name in (
            "sdg_geomsubset", "sdg_getting_started_01", "sdg_getting_started_02", "sdg_getting_started_03",
            "sdg_getting_started_04", "sdg_getting_started_05", "custom_event_and_write", "custom_fps_writer_annotator",
            "cosmos_writer_simple", "multi_camera", "sdg_workflow_01", "sdg_workflow_02", "motion_blur",
            "simulation_get_data",
        )
    },
    "replicator/cosmos_writer_warehouse.py": [()],
    "replicator/augmentation/annotator_augmentation.py": [(), ("--use_warp",)],
    "replicator/augmentation/writer_augmentation.py": [(), ("--use_warp",)],
    "testing/isaacsim.replicator.examples/ar_capture_pipeline.py": [()],
    "benchmarks/workflows/benchmark_workflow_sdg_cosmos_writer.py": [FEW_FRAMES],
    "benchmarks/workflows/benchmark_workflow_sdg_physics_randomization.py": [(*FEW_FRAMES, "--asset-count", "5")],
    "benchmarks/benchmark_camera.py": [FEW_FRAMES],
    "benchmarks/benchmark_sdg.py": [
        (*FEW_FRAMES, "--asset-count", "5"),
        (*FEW_FRAMES, "--asset-count", "5", "--num-cameras", "8", "--annotators", "all"),
    ],
    "benchmarks/validation/benchmark_sdg_validation.py": [("--num-frames", "3", "--regenerate-golden")],
    f"{SCENES}/scene_based_sdg.py": [
        (), *[("--config", f"{SCENES}/config/{name}") for name in (
            "config_basic_writer.yaml", "config_coco_writer.yaml", "config_default_writer.json",
            "config_kitti_writer.yaml",
        )]
    ],
    f"{OBJECTS}/object_based_sdg.py": [
        (), *[("--config", f"{OBJECTS}/config/{name}") for name in (
            "object_based_sdg_config.yaml", "object_based_sdg_dope_config.yaml",
            "object_based_sdg_centerpose_config.yaml",
        )]
    ],
    "replicator/infinigen/infinigen_sdg.py": [
        ("--close-on-completion",),
        ("--close-on-completion", "--config", "replicator/infinigen/config/infinigen_multi_writers_pt.yaml"),
    ],
    "api/isaacsim.replicator.grasping/grasping_workflow_sdg.py": [("--ext-folder", "../extensions", "--test")],
    "api/isaacsim.replicator.behavior/behaviors.py": [()],
    "testing/omni.syntheticdata/test_basic.py": [()],
    "deprecated/api/isaacsim.sensors.camera/camera_view.py": [("--test",)],
    "deprecated/api/isaacsim.sensors.camera/camera_pre_isp_pipeline.py": [("--test",)],
    "deprecated/api/isaacsim.replicator.domain_randomization/randomization_demo.py": [("--test",)],
    "api/isaacsim.replicator.experimental.domain_randomization/randomization_demo.py": [("--max-frames", "100")],
    "testing/isaacsim.simulation_app/test_frame_delay.py": [()],
}  # fmt: skip


def main() -> int:
    options = _options()
    options.assets_root = stand_in_assets.overlay(options.assets_root, options.out / "assets")
    scripts = options.checkout / "source" / "standalone_examples"
    passed: dict[str, bool] = {}
    print("| script | arguments | result | seconds | files |\n|---|---|---|---|---|")
    for script, arguments in _runs(options.only):
        folder = options.out / f"{Path(script).stem}_{len(list(options.out.glob(f'{Path(script).stem}_*')))}"
        folder.mkdir(parents=True)
        absolute = [str(scripts / each) if (scripts / each).exists() else each for each in arguments]
        result, seconds = _run(scripts / script, absolute, folder, options)
        files = sum(path.is_file() for path in folder.rglob("*")) - 1
        print(f"| `{script}` | {' '.join(arguments)} | {result} | {seconds:.0f} | {files} |", flush=True)
        passed[script] = passed.get(script, True) and result == "passed"
    print(f"\n{sum(passed.values())} of {len(passed)} scripts passed; what each printed is in {options.out}/*/log.txt")
    return int(not all(passed.values()))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkout", type=Path, required=True, help="a checkout of isaac-sim/IsaacSim 6.0.1")
    parser.add_argument("--assets-root", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("_out_isaac_scripts"), help="a folder per run")
    parser.add_argument("--only", default="", help="only scripts whose path contains this")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for one run")
    parser.add_argument("--device", default="cpu")
    options = parser.parse_args()
    options.checkout, options.out = options.checkout.resolve(), options.out.resolve()
    options.assets_root = options.assets_root.resolve()
    return options


def _runs(only: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    for script, runs in SCRIPTS.items():
        if only in script:
            yield from ((script, arguments) for arguments in runs)


def _run(script: Path, arguments: list[str], folder: Path, options: argparse.Namespace) -> tuple[str, float]:
    """Run one script in `folder`; return what came of it and the wall time [s]."""
    command = [sys.executable, "-m", "usdsdg", "run", "--device", options.device]
    command += ["--assets-root", str(options.assets_root), str(script), *arguments]
    started = time.monotonic()
    with (folder / "log.txt").open("w") as log:
        try:
            done = subprocess.run(command, cwd=folder, stdout=log, stderr=log, timeout=options.timeout)
        except subprocess.TimeoutExpired:
            return f"not ended after {options.timeout:.0f} s", options.timeout
    seconds = time.monotonic() - started
    if done.returncode == 0:
        return "passed", seconds
    last = [line for line in (folder / "log.txt").read_text(errors="replace").splitlines() if line.strip()][-1:]
    return f"exit {done.returncode}: {''.join(last)[:160].replace('|', '/')}", seconds


if __name__ == "__main__":
    sys.exit(main())
