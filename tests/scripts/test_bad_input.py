"""Broken scenes and folders: each defect is named with its prim or file, and the rest of the dataset is complete."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.scripts.conftest import ROOT, usdsdg

SCENE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def DomeLight "Sky"
    {
        float inputs:intensity = 800
    }
    def Camera "Camera"
    {
        float2 clippingRange = (0.01, 100)
        double3 xformOp:translate = (0, 0, 6)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "Good" ( prepend apiSchemas = ["SemanticsLabelsAPI:class"] )
    {
        token[] semantics:labels:class = ["good"]
        double size = 1
    }
    def Mesh "Empty"
    {
    }
    def Mesh "Sliver"
    {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)]
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = [0, 1, 2, 0, 1, 3]
    }
    def Cube "NotANumber"
    {
        double3 xformOp:translate = (nan, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Mesh "BadIndices"
    {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 7]
    }
    def Xform "Lost" ( references = @./not_there.usda@ )
    {
    }
    def Sphere "Untextured" ( prepend apiSchemas = ["MaterialBindingAPI"] )
    {
        double radius = 0.3
        double3 xformOp:translate = (1, 1, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        rel material:binding = </World/Looks/Painted>
    }
    def Scope "Looks"
    {
        def Material "Painted"
        {
            token outputs:surface.connect = </World/Looks/Painted/Surface.outputs:surface>
            def Shader "Surface"
            {
                uniform token info:id = "UsdPreviewSurface"
                color3f inputs:diffuseColor.connect = </World/Looks/Painted/Picture.outputs:rgb>
                token outputs:surface
            }
            def Shader "Picture"
            {
                uniform token info:id = "UsdUVTexture"
                asset inputs:file = @./missing.png@
                float3 outputs:rgb
            }
        }
    }
}
"""


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("broken")
    (folder / "scene.usda").write_text(SCENE)
    done = usdsdg("render", "scene.usda", "out", "--width=64", "--height=48", "--spp=8", "--quiet", cwd=folder)
    return folder / "out", done.stderr


@pytest.mark.parametrize(
    "named",
    ["/World/Empty", "/World/Sliver", "/World/NotANumber", "/World/BadIndices", "not_there.usda", "missing.png"],
)
def test_each_defect_is_named(rendered, named):
    lines = [line for line in rendered[1].splitlines() if line.startswith("warning: ") and named in line]
    assert lines, rendered[1]


def test_prims_without_defects_are_still_rendered_and_labeled(rendered):
    out, _ = rendered
    image = np.asarray(Image.open(out / "rgb_0000.png")).astype(float)[..., :3]
    assert image[24, 32].min() > 10
    boxes = np.load(out / "bounding_box_2d_tight_0000.npy")
    assert json.loads((out / "bounding_box_2d_tight_prim_paths_0000.json").read_text()) == ["/World/Good"]
    assert len(boxes) == 1


def test_a_file_that_is_not_usd_is_an_error_that_names_it(tmp_path):
    (tmp_path / "scene.usda").write_text("this is a shopping list")
    done = usdsdg("render", "scene.usda", "out", "--quiet", cwd=tmp_path, expect=1)
    assert "scene.usda" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_full_disk_is_an_error_and_leaves_no_partial_file(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", str(disk)], capture_output=True)
    if mounted.returncode != 0:
        pytest.skip("no right to mount a small disk here")
    try:
        done = usdsdg(
            "generate", str(ROOT / "configs" / "object_based.yaml"), "--quiet", "--set=num_frames=2",
            "--set=writer_kwargs.output_dir=disk/out", "--set=mesh_distractors_num=5", "--set=resolution=[320,240]",
            "--set=shape_distractors_num=5", "--set=path_tracing.every=0", "--set=rt_subframes=1",
            cwd=tmp_path, expect=1,
        )  # fmt: skip
        assert "the disk is full" in done.stderr
        assert "Traceback" not in done.stderr
        for path in Path(disk / "out").iterdir():
            if path.suffix == ".png":
                Image.open(path).load()
            elif path.suffix == ".json":
                json.loads(path.read_text())
                assert path.with_suffix(".png").exists()
            else:
                assert path.name in ("metadata.txt", ".usdsdg")
    finally:
        subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_named(tmp_path):
    (tmp_path / "locked").mkdir(mode=0o500)
    (tmp_path / "scene.usda").write_text(SCENE)
    done = usdsdg("render", "scene.usda", "locked/out", "--width=8", "--height=8", "--quiet", cwd=tmp_path, expect=1)
    assert "locked/out" in done.stderr
