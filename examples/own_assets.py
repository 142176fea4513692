"""The object-based scenario with assets of your own: a USD file made here, and a short configuration.

    python examples/own_assets.py [--out FOLDER] [--width PIXELS] [--frames N]

Shows what `usdsdg generate` requires of an asset, a mesh below a default prim, in meters, and how few keys a
configuration needs. Writes gear.usda, job.yaml, which `usdsdg generate job.yaml` runs again, and the dataset of
PoseWriter to FOLDER (_out/own_assets).
"""

import argparse
import subprocess
import sys
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom

CONFIG = """\
num_frames: {frames}
num_cameras: 1
resolution: [{width}, {height}]
working_area_size: [2, 2, 2]
camera_properties_kwargs: {{focalLength: 24, clippingRange: [0.01, 100]}}
camera_distance_to_target_min_max: [0.4, 0.6]
camera_collider_radius: 0
labeled_assets_and_properties:
  - {{url: ./gear.usda, label: gear, count: 6, floating: true, scale_min_max: [1, 1]}}
mesh_distractors_num: 0
shape_distractors_num: 40
path_tracing: {{every: 0}}
writer_type: PoseWriter
writer_kwargs: {{output_dir: dataset, exact_camera_frame: true, write_debug_images: true}}
"""

parser = argparse.ArgumentParser()
parser.add_argument("--out", type=Path, default="_out/own_assets")
parser.add_argument("--width", type=int, default=320)
parser.add_argument("--frames", type=int, default=4)
args = parser.parse_args()
args.out.mkdir(parents=True, exist_ok=True)

# A gear of twelve teeth, 20 cm across and 4 cm thick: two rings of 48 corners.
turns, radii = np.arange(48) * np.pi / 24, np.array([0.1, 0.1, 0.08, 0.08] * 12)
rim = np.stack([radii * np.cos(turns), radii * np.sin(turns)], axis=-1)
points = np.concatenate([np.insert(rim, 2, height, axis=1) for height in (-0.02, 0.02)])
sides = [[k, (k + 1) % 48, (k + 1) % 48 + 48, k + 48] for k in range(48)]
faces = [list(range(48))[::-1], list(range(48, 96)), *sides]

stage = Usd.Stage.CreateNew(str(args.out / "gear.usda"))
UsdGeom.SetStageMetersPerUnit(stage, 1.0)
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Gear").GetPrim())
mesh = UsdGeom.Mesh.Define(stage, "/Gear/Teeth")
mesh.CreatePointsAttr(points)
mesh.CreateFaceVertexCountsAttr([len(face) for face in faces])
mesh.CreateFaceVertexIndicesAttr(np.concatenate(faces))
mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
mesh.CreateDisplayColorAttr([(0.5, 0.35, 0.1)])
stage.Save()

(args.out / "job.yaml").write_text(CONFIG.format(frames=args.frames, width=args.width, height=args.width * 3 // 4))
# Quiet, since the commands that it names at its end are for its own folder. A run of another size is replaced.
command = [sys.executable, "-m", "usdsdg", "generate", "job.yaml", "--quiet", "--overwrite"]
sys.exit(subprocess.run(command, cwd=args.out).returncode)
