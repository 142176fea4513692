"""Every writer leaves the same bytes whether one process makes all frames, several make parts, or a run goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from pxr import UsdGeom

import usdsdg as rep
from tests.capture.part_runs import differences, folders, run, run_again, run_parts
from tests.sampled_cases import in_soak
from tests.verify import datasets
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.rerun import rrd_content
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.parts import join_parts

SIZE, FRAMES = (48, 32), 6
SPLITS = {"splits": {"train": 2, "val": 1}}
CLASSES = {"mug": 1, "can": 2, "box": 3, "ball": 4}
# By the name of the folder: writer, options, number of cameras. Some options change how files are numbered.
Table = dict[str, tuple[str, dict[str, Any], int]]
PICTURES: Table = {
    **{name: datasets.DATASETS[name] for name in ("basic", "basic_ids", "coco", "coco_plain", "drawn", "kitti")},
    "basic_shared": ("BasicWriter", {"rgb": True, "use_common_output_dir": True, "frame_padding": 1}, 2),
    "basic_history": ("BasicWriter", {"motion_vectors": True, "dense_correspondence": True, "visibility": True}, 1),
    "voc": ("VocWriter", {**SPLITS, "frames_per_scene": 2}, 2),
    "cvat": ("CvatWriter", {"shape": "polygon"}, 2),
    "kitti_names": ("KittiWriter", {"use_kitti_dir_names": True}, 2),
    "kitti_plain": ("KittiWriter", {**SPLITS, "bbox_height_threshold": 2}, 2),
}
POSES: Table = {
    **{name: datasets.DATASETS[name] for name in ("pose", "dope", "dope_exact", "ycb_node", "ycb_exact")},
    "pose_folders": ("PoseWriter", {"use_subfolders": True}, 2),
    "dope_node": ("DOPEWriter", {"class_name_to_index_map": {}}, 2),
}
OTHERS: Table = {
    "yolo": ("YoloWriter", SPLITS, 2),
    "keypoints": ("YoloWriter", {"task": "pose"}, 1),
    "bop": ("BopWriter", {}, 2),
    "bop_scenes": (
        "BopWriter", {"frames_per_scene": 2, "splits": {"train_pbr": 2, "val": 1}, "depth_scale": 1.0}, 2,
    ),
    "cosmos": ("CosmosWriter", {}, 2),
}  # fmt: skip

# Samples in large files, which end within the parts; of the second one every picture begins a file.
SHARDS: Table = {
    "webdataset": ("WebDatasetWriter", {**SPLITS, "masks": True, "shard_samples": 3}, 2),
    "webdataset_small": ("WebDatasetWriter", {"depth": True, "shard_megabytes": 0.001}, 1),
    "parquet": ("ParquetWriter", {**SPLITS, "masks": True, "shard_samples": 3, "row_group_samples": 2}, 2),
    "parquet_jpg": ("ParquetWriter", {"image_output_format": "jpg", "frames_per_scene": 2}, 1),
}


class Moving:
    """A scene that moves, in which something comes up later; now and then the second camera is off."""

    def __init__(self, table: Table, folder: Path) -> None:
        self._scene = datasets.Scene(1, count=5)
        self._products = [rep.create.render_product(path, SIZE) for path in self._scene.cameras]
        for name, (kind, options, cameras) in table.items():
            writer = rep.writers.get(kind)
            writer.initialize(output_dir=str(folder / name), **options)
            writer.attach(self._products[:cameras])

    def step(self, frame: int) -> None:
        """Capture a frame."""
        self._scene.move()
        if frame == 2:
            late = UsdGeom.Cube.Define(current_stage(), "/World/A_Late")  # before the others, in the stage's order
            late.AddScaleOp().Set((0.4, 0.4, 0.3))
            add_labels(late.GetPrim(), {"class": ["mug"]})
        self._products[1].hydra_texture.set_updates_enabled(frame not in (0, 3))
        rep.orchestrator.step(delta_time=0.0)


def moving(table: Table, frames: int = FRAMES) -> Callable[[Path], None]:
    """Return a script that writes the datasets of a table."""

    def script(folder: Path) -> None:
        scene = Moving(table, folder)
        for frame in range(frames):
            scene.step(frame)

    return script


class Died(Exception):
    """What ends a run in a test."""


def dying(table: Table, frames: int) -> Callable[[Path], None]:
    """Return a script that fails when so many frames are in the journal."""

    def script(folder: Path) -> None:
        scene = Moving(table, folder)
        for frame in range(frames):
            scene.step(frame)
        current().io_queue.wait_until_done()
        current().run.append()
        raise Died

    return script


def check(script: Callable[[Path], None], folder: Path, *, cuts: Sequence[int] = (2, 5)) -> None:
    """Compare what parts, shards and runs that went on have left with what one run has left."""
    whole = folder / "whole"
    run(script, whole)
    for name, portions in {"parts": ("4:6", "0:1", "1:4"), "shards": ("1/2", "0/2")}.items():
        run_parts(script, folder / name, *portions)
        assert differences(folder / name, whole) == [], name
    for frames in cuts:
        run_again(script, folder / f"cut_{frames}", whole, frames)
        assert differences(folder / f"cut_{frames}", whole) == [], f"after {frames} frames"


@in_soak
@pytest.mark.parametrize("table", [PICTURES, POSES, OTHERS], ids=["pictures", "poses", "others"])
def test_parts_and_runs_that_go_on_are_the_whole(table, tmp_path):
    check(moving(table), tmp_path)


@in_soak
def test_samples_in_shards_are_the_same_in_parts_and_after_failures(tmp_path):
    script, whole = moving(SHARDS), tmp_path / "whole"
    run(script, whole)
    assert not list(whole.rglob("aggregates/samples"))
    for name, portions in {"parts": ("4:6", "0:1", "1:4"), "shards": ("1/2", "0/2")}.items():
        run_parts(script, tmp_path / name, *portions)
        assert differences(tmp_path / name, whole) == [], name
    for frames in (1, 4, FRAMES):
        with pytest.raises(Died):
            run(dying(SHARDS, frames), tmp_path / f"died_{frames}")
        run(script, tmp_path / f"died_{frames}", mode=Mode.RESUME)
        assert differences(tmp_path / f"died_{frames}", whole) == [], f"after {frames} frames"


def test_recordings_hold_the_same_in_parts_and_in_runs_that_go_on(tmp_path):
    pytest.importorskip("rerun")
    table: Table = {"rerun": ("RerunWriter", {"semantic_segmentation": True}, 2)}
    script, whole = moving(table), tmp_path / "whole"

    def held(folder: Path) -> dict[str, Any]:
        # Apart from the order of metadata, which is another each time, and from what the journal says of it.
        return {path.relative_to(folder).as_posix(): rrd_content.content(path) for path in folder.rglob("*.rrd")}

    run(script, whole)
    run_parts(script, tmp_path / "parts", "4:6", "0:1", "1:4")
    with pytest.raises(Died):
        run(dying(table, 3), tmp_path / "died")
    run(script, tmp_path / "died", mode=Mode.RESUME)
    assert len(held(whole)) == FRAMES
    assert held(tmp_path / "parts") == held(whole)
    assert held(tmp_path / "died") == held(whole)


@pytest.mark.parametrize(
    "table",
    [
        pytest.param(PICTURES, marks=in_soak), pytest.param(POSES, marks=in_soak), pytest.param(OTHERS, marks=in_soak),
        pytest.param(SHARDS, marks=in_soak), {name: (OTHERS | POSES)[name] for name in ("yolo", "keypoints", "dope")},
    ],
    ids=["pictures", "poses", "others", "shards", "some"],
)  # fmt: skip
@pytest.mark.parametrize("portions", [("0:2", "2:6"), ("0/2", "1/2")], ids=["parts", "shards"])
def test_parts_that_died_go_on(table, portions, tmp_path):
    """What a writer has kept belongs after the last frame of the part, not before the frames of other parts."""
    script, whole, folder = moving(table), tmp_path / "whole", tmp_path / "parts"
    run(script, whole)
    for text in portions:
        portion = Portion.of_shard(text) if "/" in text else Portion.of_frames(text)
        with pytest.raises(Died):
            run(dying(table, 4), folder, portion)
        run(script, folder, portion, Mode.RESUME)
    for home in folders(folder):
        join_parts(FolderPlace(home))
    assert differences(folder, whole) == []
