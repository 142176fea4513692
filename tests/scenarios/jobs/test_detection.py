"""The detection job: its documented command, and what is hidden and cut off, measured."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from tests import forked
from tests.sampled_cases import sampled
from tests.scenarios.jobs.own_meshes import write_three
from tests.scenarios.jobs.page import documented
from usdsdg.scenarios.detection.arrangement import CUT, HIDDEN, Arranger
from usdsdg.scenarios.detection.config import DetectionConfig
from usdsdg.scenarios.detection.scene import build, sizes_of
from usdsdg.scenarios.detection.sight import measure
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.jobs import load_job
from usdsdg.scenarios.shared.decks import deal, variants
from usdsdg.scenarios.shared.mesh_folder import read_assets

ROOT = Path(__file__).parents[3]
SMALL = ("--set", "num_frames=5", "--set", "resolution=[160,120]")


def usdsdg(*arguments: str, cwd: Path, fresh: bool = False) -> str:
    """Run the command line as a user does, `fresh` as in `forked.run`; return what it prints."""
    done = forked.run(["-m", "usdsdg", *arguments], cwd=cwd, timeout=600, fresh=fresh)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def digests(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.blake2b(path.read_bytes()).hexdigest() for path in files}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """What the documented command writes for three OBJ files, and what it says."""
    folder = tmp_path_factory.mktemp("detection")
    write_three(folder / "parts")
    return folder, usdsdg(*documented("configs/detection.yaml", "parts"), *SMALL, cwd=folder, fresh=True)


def test_three_obj_files_become_a_yolo_and_a_coco_dataset(dataset):
    folder, said = dataset
    assert "block.obj is read in mm" in said
    assert "5 frames, 5 pictures" in said
    described = yaml.safe_load((folder / "_out_detection/yolo/data.yaml").read_text())
    assert described["names"] == {0: "block", 1: "panel", 2: "wedge"}
    assert (described["train"], described["val"]) == ("images/train", "images/val")
    pictures = sorted((folder / "_out_detection/yolo/images").rglob("*.png"))
    assert sorted(path.parent.name for path in pictures) == ["train"] * 4 + ["val"]
    lines = [line.split() for path in (folder / "_out_detection/yolo/labels").rglob("*.txt") for line in path.open()]
    assert len(lines) >= 5
    assert {int(line[0]) for line in lines} == {0, 1, 2}
    pixels = np.stack([np.asarray(Image.open(path).convert("RGB"), float) for path in pictures])
    # Neither dark nor burnt out, and no two alike.
    assert 25 < pixels.mean() < 225
    assert min(np.abs(a - b).mean() for k, a in enumerate(pixels) for b in pixels[:k]) > 5


def test_coco_has_the_same_boxes(dataset):
    folder, _ = dataset
    boxes = []
    for file in sorted((folder / "_out_detection/coco").rglob("*.json")):
        if ".usdsdg" in file.parts or "annotations" not in json.loads(file.read_text()):
            continue
        data = json.loads(file.read_text())
        names = {each["id"]: each["name"] for each in data["categories"]}
        boxes += [(names[each["category_id"]], *each["bbox"]) for each in data["annotations"]]
    known = ["block", "panel", "wedge"]
    expected = []
    for path in (folder / "_out_detection/yolo/labels").rglob("*.txt"):
        for label, *box in (line.split() for line in path.open()):
            x, y, width, height = np.array(box, float) * (160, 120, 160, 120)
            expected.append((known[int(label)], *np.round((x - width / 2, y - height / 2, width, height))))
    assert sorted(boxes) == sorted(expected)


def test_the_datasets_are_verified(dataset):
    folder, _ = dataset
    for name in ("yolo", "coco"):
        assert "0 faults" in usdsdg("verify", f"_out_detection/{name}", cwd=folder)


def test_the_same_command_writes_the_same_bytes(dataset, tmp_path):
    folder, _ = dataset
    write_three(tmp_path / "parts")
    config = str(ROOT / "configs" / "detection.yaml")
    usdsdg("generate", config, "--set", "meshes=parts", *SMALL, cwd=tmp_path)
    for name in ("yolo/labels", "yolo/images", "yolo/data.yaml"):
        before, after = (each / "_out_detection" / name for each in (folder, tmp_path))
        assert (before.read_bytes() == after.read_bytes()) if before.is_file() else digests(before) == digests(after)


def arranged(config: DetectionConfig, frames: int):
    """Yield what the camera sees of each object, by frame, without rendering pictures."""
    draws, assets = Draws(config.seed, "detection"), read_assets(config.files(), config.mesh_unit)
    hands = variants(deal(draws, [4] * frames, dict.fromkeys(config.files(), 1.0)), sizes_of(assets))
    scene = build(config, hands, assets)
    arranger = Arranger(config, draws, scene.seen, scene.camera)
    size = (scene.seen.width, scene.seen.height)
    every = [body for bodies in scene.objects.values() for body in bodies]
    for frame, hand in enumerate(hands):
        for body in (*every, *scene.distractors):
            body.show(False)
        free = {kind: list(bodies) for kind, bodies in scene.objects.items()}
        bodies = [free[kind].pop() for kind in hand]
        arranger.arrange(frame, bodies, scene.distractors[:6])
        yield [each for each in measure(scene.camera, size, [body.prim for body in bodies]) if each.pixels]


@pytest.mark.parametrize("frames", sampled([16, 40]))
def test_what_is_hidden_and_cut_off_is_as_wanted(frames, stage, tmp_path):
    changes = [
        f"meshes={write_three(tmp_path)}", "occlusion={share: 0.5, most: 0.6}", "truncation={share: 0.3, most: 0.4}",
        "distractors.meshes=''", "backgrounds.share_of_pictures=0", "resolution=[320, 240]",
    ]  # fmt: skip
    _, config = load_job(ROOT / "configs" / "detection.yaml", changes)
    seen = [each for frame in arranged(config, frames) for each in frame]
    assert len(seen) > 3.5 * frames  # of 4 in each: the others found no place
    assert max(each.occlusion for each in seen) <= 0.6
    assert max(each.truncation for each in seen) <= 0.4
    assert np.mean([each.occlusion > HIDDEN for each in seen]) == pytest.approx(0.5, abs=0.15)
    assert np.mean([each.truncation > CUT for each in seen]) == pytest.approx(0.3, abs=0.15)


def test_nothing_is_hidden_or_cut_off_where_nothing_may_be(stage, tmp_path):
    changes = [
        f"meshes={write_three(tmp_path)}", "occlusion={share: 0, most: 0}", "truncation={share: 0, most: 0}",
        "distractors.meshes=''", "backgrounds.share_of_pictures=0",
    ]  # fmt: skip
    _, config = load_job(ROOT / "configs" / "detection.yaml", changes)
    seen = [each for frame in arranged(config, 10) for each in frame]
    assert len(seen) > 30
    assert all(each.occlusion == each.truncation == 0 for each in seen)
