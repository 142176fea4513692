"""Small whole files of each kind, and the command that reads each."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Sdf, UsdUtils

STAGE = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)

def Xform "World"
{
    def Mesh "Plate" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
            interpolation = "vertex"
        )
        rel material:binding = </World/Painted>
    }
    def Sphere "Ball"
    {
        double radius = 0.4
        color3f[] primvars:displayColor = [(0.8, 0.3, 0.1)]
        double3 xformOp:translate = (0.2, 0.1, 0.5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def DomeLight "Sky"
    {
        float inputs:intensity = 700
    }
    def Material "Painted"
    {
        token outputs:surface.connect = </World/Painted/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </World/Painted/Texture.outputs:rgb>
            token outputs:surface
        }
        def Shader "Texture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./color.png@
            float2 inputs:st.connect = </World/Painted/Coordinates.outputs:result>
            float3 outputs:rgb
        }
        def Shader "Coordinates"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }
    }
}
"""
CONFIG = """num_frames: 1
num_cameras: 1
seed: 3
resolution: [32, 24]
path_tracing: {every: 0}
camera_distance_to_target_min_max: [0.4, 0.75]
labeled_assets_and_properties:
  - {url: /Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd, label: pudding_box, count: 2, floating: true}
shape_distractors_types: [cube, sphere]
shape_distractors_num: 3
mesh_distractors_num: 0
writer_type: PoseWriter
writer_kwargs: {output_dir: OUT}
"""
GRAPH = """camera: {create.camera: {position: [0, 0, 5], look_at: [0, 0, 0]}}
light: {create.light: {light_type: dome, intensity: 700}}
cube: {create.cube: {semantics: [[class, cube]], count: 2}}
product: {create.render_product: {camera: camera, resolution: [32, 24]}}
writer: {writers.get: {name: BasicWriter}}
set: {writer.initialize: {output_dir: OUT, rgb: true, bounding_box_2d_tight: true}}
attach: {writer.attach: {render_products: product}}
trigger:
  trigger.on_frame: {num_frames: 1, max_execs: 1}
  with.trigger:
    move:
      inputs: {prims: cube}
"""
SAVING = """
import sys
import omni.replicator.core as rep
camera = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
rep.create.light(light_type="dome")
cube = rep.create.cube(semantics=[("class", "cube")])
with rep.trigger.on_frame(num_frames=1):
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 0)))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(rep.create.render_product(camera, (32, 24)))
rep.orchestrator.run()
"""


@dataclass(frozen=True)
class Original:
    """A whole file, and what reads it."""

    kind: str
    file: Path  # the one that is mutated
    opened: str  # the name of the file that is given to the command, beside it
    has_checksums: bool  # so that a change of any byte is noticed

    def arguments(self, folder: Path, output: Path) -> list[str]:
        """Return the command on a copy in a folder."""
        opened = str(folder / self.opened)
        if self.kind == "config":
            return ["generate", "-q", opened, "--device", "cpu", "--set", f"writer_kwargs.output_dir={output}"]
        if self.kind == "graph":
            return ["run", "-q", "--device", "cpu", "--allow-outside", opened]
        if self.kind == "saved":
            return [
                "generate",
                "-q",
                opened,
                "--device",
                "cpu",
                "--set",
                f"output_dir={output}",
                "--set",
                "num_frames=1",
            ]
        size = ["--width", "32", "--height", "24", "--spp", "2"]
        return ["render", "-q", opened, str(output), "--device", "cpu", *size]


def originals(folder: Path, output: Path) -> list[Original]:
    """Make the originals below a folder; output: where graphs write."""
    found = []
    for kind in ("usda", "usdc", "png", "jpg", "hdr", "usdz", "config", "graph", "saved"):
        place = folder / kind
        place.mkdir(parents=True)
        found.append(_make(kind, place, output))
    return found


def _make(kind: str, place: Path, output: Path) -> Original:
    pixels = np.random.default_rng(0).integers(0, 255, (8, 8, 3), dtype=np.uint8)
    if kind == "config":
        (place / "job.yaml").write_text(CONFIG)
        return Original(kind, place / "job.yaml", "job.yaml", has_checksums=False)
    if kind == "graph":
        graph = GRAPH[: GRAPH.index("  with.trigger")].replace("OUT", json.dumps(str(output)))
        (place / "graph.yaml").write_text(graph)
        return Original(kind, place / "graph.yaml", "graph.yaml", has_checksums=False)
    if kind == "saved":
        (place / "save.py").write_text(SAVING)
        command = [sys.executable, "-m", "usdsdg", "run", "-q", "--device", "cpu", "--save-stage"]
        subprocess.run([*command, str(place / "saved.usda"), str(place / "save.py"), str(place / "made")], check=True)
        shutil.rmtree(place / "made")
        return Original(kind, place / "saved.usda", "saved.usda", has_checksums=False)
    suffix = kind if kind in ("png", "jpg", "hdr") else "png"
    texture = place / f"color.{suffix}"
    if kind == "hdr":
        texture.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 8\n" + bytes([90, 120, 60, 129]) * 64)
    else:
        Image.fromarray(pixels).save(texture)
    (place / "stage.usda").write_text(STAGE.replace("color.png", texture.name))
    if kind in ("png", "jpg", "hdr"):
        return Original(kind, texture, "stage.usda", has_checksums=kind == "png")
    if kind == "usda":
        return Original(kind, place / "stage.usda", "stage.usda", has_checksums=False)
    if kind == "usdc":
        Sdf.Layer.FindOrOpen(str(place / "stage.usda")).Export(str(place / "crate.usdc"))
        return Original(kind, place / "crate.usdc", "crate.usdc", has_checksums=False)
    UsdUtils.CreateNewUsdzPackage(str(place / "stage.usda"), str(place / "package.usdz"))
    return Original(kind, place / "package.usdz", "package.usdz", has_checksums=True)
