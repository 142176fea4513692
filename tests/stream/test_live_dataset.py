"""LiveDataset under PyTorch's DataLoader."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("torch")

SCENE = Path(__file__).parent / "scene.py"

LOADERS = """
import hashlib, json, sys
import torch
from torch.utils.data import DataLoader
from usdsdg.torch import LiveDataset

def plain(batch):
    return [int(batch["frame"]), hashlib.md5(batch["rgb"].numpy().tobytes()).hexdigest(),
            batch["bounding_box_2d_tight"]["x_min"].tolist()]

def size(sample):
    return sample["rgb"].shape[:2]

if __name__ == "__main__":
    options = dict(annotators=["rgb", "bounding_box_2d_tight"], arguments=["4"], seed=3)
    dataset = LiveDataset(sys.argv[1], **options)
    found = {}
    for workers, method in ((1, "fork"), (2, "fork"), (2, "spawn"), (0, None)):
        loader = DataLoader(dataset, batch_size=None, num_workers=workers, multiprocessing_context=method)
        found[f"{workers} {method}"] = sorted(plain(batch) for batch in loader)
    dataset.set_epoch(1)
    found["next"] = sorted(plain(batch) for batch in DataLoader(dataset, batch_size=None, num_workers=1))
    batches = DataLoader(LiveDataset(sys.argv[1], ["rgb"], arguments=["4"], transform=size), batch_size=None)
    found["sizes"] = [list(each) for each in batches]
    print(json.dumps(found))
"""


def test_workers_and_start_methods_give_the_same_frames(tmp_path):
    (tmp_path / "loaders.py").write_text(LOADERS)
    command = [sys.executable, "loaders.py", str(SCENE)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    one = found["1 fork"]
    assert [row[0] for row in one] == [0, 1, 2, 3]
    assert found["2 fork"] == found["2 spawn"] == found["0 None"] == one
    assert found["next"] != one
    assert found["sizes"] == [[32, 48]] * 4


def test_ids_and_records_become_tensors_that_share_memory_where_they_can():
    import numpy as np
    import torch

    from usdsdg.torch.tensors import tensor

    picture = np.zeros((2, 3, 4), np.uint8)
    shared = tensor(picture)
    assert isinstance(shared, torch.Tensor)
    picture[0, 0, 0] = 7
    assert shared[0, 0, 0] == 7
    ids = tensor(np.array([2**31 - 1, 5], np.uint32))
    assert isinstance(ids, torch.Tensor)
    assert ids.tolist() == [2**31 - 1, 5]
    assert ids.dtype == torch.int64
    boxes = np.zeros(2, [("x_min", np.int32), ("occlusionRatio", np.float32), ("name", "U4")])
    boxes["x_min"] = 3, 4
    fields = tensor(boxes)
    assert isinstance(fields, dict)
    assert sorted(fields) == ["occlusionRatio", "x_min"]
    assert fields["x_min"].tolist() == [3, 4]


WORLDS = """
import json, sys
import torch
from torch.utils.data import DataLoader
from usdsdg.errors import ArgumentError
from usdsdg.torch import LiveDataset

if __name__ == "__main__":
    names = ["rgb", "distance_to_camera", "bounding_box_2d_tight"]
    options = dict(arguments=["4", "24"], seed=3)
    batches = list(LiveDataset(sys.argv[1], names, worlds=2, **options))
    frames = list(LiveDataset(sys.argv[1], names[:2], **options))
    same = [
        bool(torch.equal(batches[k // 2][name][k % 2], frames[k][name])) for k in range(4) for name in names[:2]
    ]
    shapes = {name: list(batches[0][name].shape) for name in names}
    prims = len(batches[0]["prims"]), batches[0]["class_ids"].tolist(), sorted(batches[0]["classes"])
    try:
        next(iter(DataLoader(LiveDataset(sys.argv[1], names, worlds=2, **options), batch_size=None, num_workers=1)))
        failure = ""
    except Exception as error:
        failure = str(error)
    print(json.dumps([same, shapes, prims, [batch["frame"] for batch in batches], failure]))
"""


def test_worlds_are_batches_of_tensors_with_the_frames_of_single_ones(tmp_path):
    (tmp_path / "worlds.py").write_text(WORLDS)
    scene = Path(__file__).parents[2] / "examples/scenes/moving_shapes.py"
    command = [sys.executable, "worlds.py", str(scene)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    same, shapes, (prims, class_ids, classes), frames, failure = json.loads(done.stdout.splitlines()[-1])
    assert all(same)
    assert shapes == {
        "rgb": [2, 24, 24, 4], "distance_to_camera": [2, 24, 24], "bounding_box_2d_tight": [2, 15, 5],
    }  # fmt: skip
    assert prims == len(class_ids) == 15
    assert set(class_ids) == set(classes)
    assert frames == [0, 2]
    assert "num_workers=0" in failure
