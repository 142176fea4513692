"""`usdsdg warmup` in an empty cache; then runs of many kinds compile nothing more, and say nothing of first use."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Jobs, and what makes them short.
JOBS = {
    "object_based": ("num_frames=2", "resolution=[160,120]", "path_tracing.spp=2"),
    "detection": ("num_frames=2",),
    "bin_picking": ("drops=1", "frames_per_drop=1"),
}
ANNOTATED = """
import usdsdg as rep

rep.create.light(light_type="Dome")
rep.create.light(light_type="Distant")
ground = rep.create.plane(scale=10)
with ground:
    rep.physics.collider()
things = [make(semantics=[("class", "thing")], position=(0, 0, 2 + 2 * i)) for i, make in enumerate(
    (rep.create.cube, rep.create.sphere, rep.create.cylinder, rep.create.cone, rep.create.torus))]
for thing in things:
    with thing:
        rep.physics.rigid_body()
camera = rep.create.camera(position=(12, 0, 6), look_at=(0, 0, 2))
product = rep.create.render_product(camera, (160, 120))
writer = rep.writers.get("BasicWriter")
writer.initialize(
    output_dir=OUT, rgb=True, bounding_box_2d_tight=True, bounding_box_2d_loose=True, bounding_box_3d=True,
    semantic_segmentation=True, instance_segmentation=True, instance_id_segmentation=True, normals=True, occlusion=True,
    distance_to_camera=True, distance_to_image_plane=True, motion_vectors=True, pointcloud=True, camera_params=True,
)
writer.attach(product)
rep.orchestrator.run(num_frames=2)
"""
CUBES_ALONE = """#usda 1.0
def Cube "a" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] ) {}
def Cube "b" ( prepend apiSchemas = ["PhysicsCollisionAPI"] ) { double3 xformOp:translate = (0, 0, -3)
    uniform token[] xformOpOrder = ["xformOp:translate"] }
"""


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "annotated.py").write_text(
            ANNOTATED.replace("OUT", repr(str(folder / "annotated"))), encoding="utf-8"
        )
        (folder / "cubes.usda").write_text(CUBES_ALONE, encoding="utf-8")
        print(_run(folder, "warmup", "--device", "cpu"), flush=True)
        compiled = _binaries(folder)
        faults = _check_runs(folder, compiled)
        again = _run(folder, "warmup", "--device", "cpu")
        if "nothing to compile" not in again:
            faults.append(f"a second warmup compiled: {again}")
    print(f"{len(compiled)} binaries; faults: {faults or 'none'}")
    return int(bool(faults) or not compiled)


def _check_runs(folder: Path, compiled: set[str]) -> list[str]:
    """Run what compiles most kinds of kernels; return what was compiled, or said to be, after all."""
    faults = []
    jobs = [
        [str(ROOT / f"configs/{name}.yaml"), *(part for each in little for part in ("--set", each))]
        for name, little in JOBS.items()
    ]
    for command, *arguments in (
        ["run", "annotated.py"],
        ["simulate", "cubes.usda", "fallen.usda", "--seconds", "0.1"],
        ["render", "cubes.usda", "cubes"],
        *(["generate", *job] for job in jobs),
    ):
        output = _run(folder, command, "--device", "cpu", *arguments)
        name = f"{command} {Path(arguments[0]).name}"
        faults += [f"{name} compiled {each}" for each in sorted(_binaries(folder) - compiled)]
        faults += [f"{name} says: {line}" for line in output.splitlines() if "first use" in line]
    return faults


def _run(folder: Path, *arguments: str) -> str:
    environment = {**os.environ, "WARP_CACHE_PATH": str(folder / "kernels"), "PYTHONPATH": str(ROOT)}
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-m", "usdsdg", *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"usdsdg {' '.join(arguments)}:\n{done.stdout}{done.stderr}")
    print(f"usdsdg {' '.join(arguments[:4])}: {time.monotonic() - began:.0f} s", flush=True)
    return done.stdout + done.stderr


def _binaries(folder: Path) -> set[str]:
    return {file.name for file in (folder / "kernels").rglob("*.o")}


if __name__ == "__main__":
    sys.exit(main())
