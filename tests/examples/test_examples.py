"""Every example, at a small size, run as a user would: its files exist, and a number agrees with a hand calculation."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from pxr import Usd

from tests import forked
from tests.scripts.conftest import ROOT, usdsdg

EXAMPLES = ROOT / "examples"
WITHOUT_IMAGE = ("train_live_detector",)  # what it finds depends on how long it is trained
# Focal length of Replicator's default camera as a fraction of the image width.
FOCAL = 24 / 20.955


def run(name: str, folder: Path, *options: str) -> Path:
    """Run an example; return its output folder."""
    done = forked.run([str(EXAMPLES / f"{name}.py"), "--out", "out", *options], cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out"


def test_first_script(tmp_path):
    script = str(EXAMPLES / "first_script.py")
    usdsdg("run", "--quiet", script, "--out", "out", "--width", "160", "--frames", "2", cwd=tmp_path)
    # The cube is 1 m wide, its front 4.5 m and the far edge of its top 5.5 m away, 0.4 m below the camera; its bottom
    # is outside of the image. Its first pixels are those whose centers are inside.
    left, top = 80 - 160 * FOCAL * 0.5 / 4.5, 45 + 160 * FOCAL * 0.4 / 5.5
    box = [round(left), round(top), 159 - round(left), 89]
    for frame in ("0000", "0001"):
        assert Image.open(tmp_path / f"out/rgb_{frame}.png").size == (160, 90)
        names = json.loads((tmp_path / f"out/bounding_box_2d_tight_labels_{frame}.json").read_text())
        boxes = {
            names[str(each["semanticId"])]["class"]: [int(each[edge]) for edge in ("x_min", "y_min", "x_max", "y_max")]
            for each in np.load(tmp_path / f"out/bounding_box_2d_tight_{frame}.npy")
        }
        assert boxes["cube"] == box
        assert np.load(tmp_path / f"out/distance_to_image_plane_{frame}.npy")[80, 80] == pytest.approx(4.5)
    assert not (tmp_path / "out/rgb_0002.png").exists()


def test_yolo_writer(tmp_path):
    out = run("yolo_writer", tmp_path, "--width=160", "--frames=1")
    width, height = Image.open(out / "picture_0000.png").size
    coins = np.loadtxt(out / "picture_0000.txt")
    assert sorted(coins[:, 0]) == [0] * 6 + [1] * 6
    # Coins of 0.4 m are seen from 4.95 m, with a small part of their rims.
    across = 0.4 / 4.95 * FOCAL * width
    np.testing.assert_allclose(coins[:, 3] * width, across, atol=1.5)
    np.testing.assert_allclose(coins[:, 4] * height, across, atol=1.5)


def test_own_annotators(tmp_path):
    out = run("own_annotators", tmp_path, "--width=120")
    assert Image.open(out / "amodal_boxes.png").size == (150, 90)
    pair = np.array(Image.open(out / "correspondence.png").convert("RGB"), float)
    made, rendered = pair[:, :120], pair[:, 120:]
    filled = made.any(axis=2)
    assert 0.3 < filled.mean() < 1
    # Points look the same from both cameras, but at edges and in noise.
    assert np.median(np.abs(made - rendered)[filled]) < 12


def test_many_cameras(tmp_path):
    out = run("many_cameras", tmp_path, "--width=160", "--cameras=2")
    coco = json.loads((out / "annotations.json").read_text())
    assert Image.open(out / "masks.png").size == (2 * 160, 120)
    boxes = {}
    for each in coco["annotations"]:
        inside = np.repeat(np.arange(len(each["segmentation"]["counts"])) % 2, each["segmentation"]["counts"])
        rows, columns = np.nonzero(inside.reshape(each["segmentation"]["size"], order="F"))
        assert each["area"] == len(rows)
        x, y, width, height = each["bbox"]
        assert (x, y, x + width - 1, y + height - 1) == (columns.min(), rows.min(), columns.max(), rows.max())
        boxes[each["image_id"], coco["categories"][each["category_id"]]["name"]] = x, x + width
    # Nothing hides the nearest ball. The vertical planes through the first camera, which looks along -X and slightly
    # down, that touch the ball give its first and last column.
    positions = [(0.45 * k**0.5 * np.cos(2.4 * k), 0.45 * k**0.5 * np.sin(2.4 * k), 0.08 * k) for k in range(12)]
    nearest = min(range(12), key=lambda k: np.linalg.norm(np.subtract(positions[k], (6, 0, 2))))
    ahead = np.array([-6, 0, -1.6]) / np.hypot(6, 1.6)
    right, depth = positions[nearest][1], np.subtract(positions[nearest], (6, 0, 2)) @ ahead
    middle, half = np.arctan2(right, depth), np.arcsin(0.3 / np.hypot(right, depth))
    edges = 80 + 160 * 35 / 20.955 * np.tan([middle - half, middle + half])
    np.testing.assert_allclose(boxes[0, f"/World/Ball_{nearest:02}"], edges, atol=1)


def test_hidden_parts(tmp_path):
    out = run("hidden_parts", tmp_path, "--width=240")
    report = json.loads((out / "hidden_parts.json").read_text())
    assert Image.open(out / "hidden_parts.png").size == (240, 120)
    # The crate's front is 2 m wide, 7 m away, in the center of the image; the wall ends there too.
    first = round(120 - 240 * FOCAL / 7)
    columns = report["crate"]["whole box"][0], report["crate"]["whole box"][2]
    assert columns == (first, 239 - first)
    assert report["crate"]["visible share"] == 0.5
    assert report["wall"]["hidden by"] == {}
    assert list(report["ball"]["hidden by"]) == ["crate"]


def test_depth_of_field(tmp_path):
    out = run("depth_of_field", tmp_path, "--width=64", "--samples=4")
    assert Image.open(out / "picture.png").size == (64, 32)
    assert (out / "sky.png").is_file()
    # The ray of the middle pixel is half a pixel off the axis; the ball has 0.5 m radius, 64 sides and is 6 m away.
    k = 1 + 2 * (0.5 / (64 * 35 / 20.955)) ** 2
    depth = (6 - np.sqrt(36 - k * (36 - 0.25))) / k
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    focus = stage.GetAttributeAtPath("/World/Camera.focusDistance").Get()
    assert focus == pytest.approx(depth, abs=0.5 * (1 - np.cos(np.pi / 64) ** 2))


def test_fisheye_points(tmp_path):
    out = run("fisheye_points", tmp_path, "--width=120")
    assert Image.open(out / "views.png").size == (240, 120)
    beside = {}
    for name in ("pinhole", "fisheye"):
        points = np.asarray(trimesh.load(out / f"{name}.ply").vertices)
        assert len(points) > 1000
        # Floor and tops of blocks are horizontal; sides of blocks are 0.4 m from the block's center along X or Y.
        angles = np.arange(12) * np.pi / 6
        offsets = np.abs(points[:, None, :2] - 4 * np.stack([np.cos(angles), np.sin(angles)], -1)).max(-1).min(-1)
        error = np.minimum(np.abs(points[:, 2] * (points[:, 2] - 1.5)), np.abs(offsets - 0.4))
        assert error.max() < 1e-4
        # The block at 4 m to the left, 90 degrees from the axis, shows its side 3.6 m away.
        beside[name] = np.count_nonzero((np.abs(points[:, 0]) < 0.4) & (np.abs(points[:, 1] - 3.6) < 1e-4))
    assert beside["pinhole"] == 0
    assert beside["fisheye"] > 20


def test_physics_drop(tmp_path):
    out = run("physics_drop", tmp_path, "--width=48")
    assert Image.open(out / "picture.png").size == (3 * 48, 48)
    heights = json.loads((out / "heights.json").read_text())
    # 15 steps of 1/60 s: half a step of travel is 0.02 m.
    fallen = 9.81 / 2 * 0.25**2
    expected = [2.0 - fallen] * 9 + [2.8 - fallen] * 9
    np.testing.assert_allclose(heights["after a quarter of a second"], expected, atol=0.021)
    np.testing.assert_allclose(sorted(heights["at rest"]), [0.25] * 9 + [0.75] * 9, atol=0.002)
    assert min(heights["tossed"]) > 0.25


def test_own_assets(tmp_path):
    out = run("own_assets", tmp_path, "--width=96", "--frames=1")
    found = json.loads((out / "dataset/000000.json").read_text())["objects"]
    assert found
    for gear in found:
        assert gear["label"] == "gear"
        np.testing.assert_allclose(gear["size"], (0.2, 0.2, 0.04), atol=1e-4)
    run("own_assets", tmp_path, "--width=64", "--frames=1")  # as one does who tries a size, and then another
    assert Image.open(out / "dataset/000000.png").size == (64, 48)


def test_train_live_detector(tmp_path):
    torch = pytest.importorskip("torch")
    out = run("train_live_detector", tmp_path, "--width=64", "--steps=2", "--batch=2")
    assert Image.open(out / "detector.png").size == (2 * 64, 64)
    weights = torch.load(out / "detector.pt")
    assert sum(each.numel() for name, each in weights.items() if name.endswith("weight")) > 1e6


def test_the_table_of_the_readme_lists_every_example():
    table = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for script in EXAMPLES.glob("*.py"):
        image = ROOT / "docs/images" / f"example_{script.stem}.png"
        assert f"({script.name})" in table
        if script.stem in WITHOUT_IMAGE:
            continue
        assert f"(../docs/images/{image.name})" in table
        assert image.stat().st_size < 60_000
