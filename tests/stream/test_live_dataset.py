"""LiveDataset under PyTorch's DataLoader."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from usdsdg.errors import ArgumentError

pytest.importorskip("torch")

SCENE = Path(__file__).parent / "scene.py"
ROOT = Path(__file__).parents[2]
# A process that was forked from one that uses CUDA cannot use it.
ON_CPU = {
    **os.environ,
    "CUDA_VISIBLE_DEVICES": "",
    "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")])),
}

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
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280, env=ON_CPU)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    one = found["1 fork"]
    assert [row[0] for row in one] == [0, 1, 2, 3]
    assert found["2 fork"] == found["2 spawn"] == found["0 None"] == one
    assert found["next"] != one
    assert found["sizes"] == [[32, 48]] * 4


EPOCHS = """
import hashlib, json
from pathlib import Path
from torch.utils.data import DataLoader
from tests.cli.datasets import write_job
from usdsdg import stream
from usdsdg.torch import LiveDataset

def digest(array):
    return hashlib.md5(array.tobytes()).hexdigest()

def of_loader(dataset):
    samples = DataLoader(dataset, batch_size=None, num_workers=1)
    return [digest(each["rgb"].numpy()) for each in samples]

if __name__ == "__main__":
    job = write_job(Path("."), "BasicWriter", rgb=True)
    small = ["num_frames=2", "path_tracing.every=0", "num_cameras=1"]
    seeds = {}
    for seed in (3, 5, 7):
        samples = stream.frames(job, ["rgb"], arguments=small, seed=seed)
        seeds[seed] = [digest(each.arrays["rgb"]) for each in samples]
    found = {}
    for name, options in {"file": {}, "override": {"arguments": [*small, "seed=5"]}, "asked": {"seed": 5}}.items():
        dataset = LiveDataset(job, ["rgb"], **{"arguments": small, **options})
        found[name] = of_loader(dataset)
        dataset.set_epoch(2)
        found[name + " + 2"] = of_loader(dataset)
    print(json.dumps([seeds, found]))
"""


def test_the_seed_is_that_of_the_configuration_and_epochs_count_from_it(tmp_path):
    (tmp_path / "epochs.py").write_text(EPOCHS)
    done = subprocess.run(
        [sys.executable, "epochs.py"], cwd=tmp_path, capture_output=True, text=True, timeout=280, env=ON_CPU
    )
    assert done.returncode == 0, done.stderr
    seeds, found = json.loads(done.stdout.splitlines()[-1])
    assert len({tuple(each) for each in seeds.values()}) == 3
    assert found["file"] == seeds["3"]
    assert found["file + 2"] == found["override"] == found["asked"] == seeds["5"]
    assert found["override + 2"] == found["asked + 2"] == seeds["7"]


PARTS = """
import hashlib, json, sys
from torch.utils.data import DataLoader
from usdsdg.torch import LiveDataset

def rows(workers, **options):
    dataset = LiveDataset(sys.argv[1], ["distance_to_camera"], arguments=["5"], **options)
    samples = DataLoader(dataset, batch_size=None, num_workers=workers)
    found = [[int(each["frame"]), hashlib.md5(each["distance_to_camera"].numpy().tobytes()).hexdigest()]
             for each in samples]
    return sorted(found)

if __name__ == "__main__":
    parts = [[rows(workers, part=(rank, 2)) for rank in range(2)] for workers in (0, 1, 2)]
    print(json.dumps([rows(0), parts]))
"""


def test_processes_that_train_together_take_parts_whatever_workers_they_have(tmp_path):
    (tmp_path / "parts.py").write_text(PARTS)
    command = [sys.executable, "parts.py", str(SCENE)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280, env=ON_CPU)
    assert done.returncode == 0, done.stderr
    whole, parts = json.loads(done.stdout.splitlines()[-1])
    assert len(whole) == 5
    for first, second in parts:
        assert first == whole[0::2]
        assert second == whole[1::2]


def test_what_is_no_part_is_refused():
    from usdsdg.torch import LiveDataset

    for part in ((2, 2), (-1, 2), 3, None):
        with pytest.raises(ArgumentError, match=r"LiveDataset: part is .*; expected \(i, n\)"):
            LiveDataset(SCENE, part=part)  # pyright: ignore[reportArgumentType]
    for device in ("cudaa", 1.5, "cpu:x"):
        with pytest.raises(ArgumentError, match="expected a device of torch"):
            LiveDataset(SCENE, device=device)
    with pytest.raises(ArgumentError, match="a seed of its own"):
        LiveDataset(SCENE, worlds=2, part=(0, 2))


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
    # The kernels that trace labels round differently on CUDA.
    close = {"rgb": 0.0, "distance_to_camera": 1e-6 if torch.cuda.is_available() else 0.0}
    same = [
        bool(torch.allclose(batches[k // 2][name][k % 2].cpu(), frames[k][name].cpu(), rtol=close[name], atol=0.0))
        for k in range(4) for name in names[:2]
    ]
    shapes = {name: list(batches[0][name].shape) for name in names}
    prims = len(batches[0]["prims"]), batches[0]["class_ids"].tolist(), sorted(batches[0]["classes"])
    try:
        next(iter(DataLoader(LiveDataset(sys.argv[1], names, worlds=2, **options), batch_size=None, num_workers=1)))
        failure = ""
    except Exception as error:
        failure = str(error)
    # A device of torch on which nothing can be rendered, as "mps" is.
    (elsewhere,) = LiveDataset(sys.argv[1], names, worlds=4, device="meta", **options)
    devices = sorted({elsewhere[name].device.type for name in (*names, "class_ids")})
    print(json.dumps([same, shapes, prims, [batch["frame"] for batch in batches], failure, devices]))
"""


def test_worlds_are_batches_of_tensors_with_the_frames_of_single_ones(tmp_path):
    (tmp_path / "worlds.py").write_text(WORLDS)
    scene = ROOT / "examples/scenes/moving_shapes.py"
    command = [sys.executable, "worlds.py", str(scene)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    same, shapes, (prims, class_ids, classes), frames, failure, devices = json.loads(done.stdout.splitlines()[-1])
    assert all(same)
    assert shapes == {
        "rgb": [2, 24, 24, 4], "distance_to_camera": [2, 24, 24], "bounding_box_2d_tight": [2, 15, 5],
    }  # fmt: skip
    assert prims == len(class_ids) == 15
    assert set(class_ids) == set(classes)
    assert frames == [0, 2]
    assert "num_workers=0" in failure
    assert devices == ["meta"]


HELD = """
import sys
from torch.utils.data import DataLoader
from usdsdg.torch import LiveDataset

options = dict(arguments=["99", "24"], worlds=int(sys.argv[2]) or None)
held = iter(DataLoader(LiveDataset(sys.argv[1], **options), batch_size=None))
print(next(held)["frame"])
"""


@pytest.mark.parametrize("worlds", [0, 2])
def test_nothing_is_printed_at_the_end_of_a_program_that_holds_an_iterator(worlds, tmp_path):
    """Python clears modules before the names of a program that has loaded torch."""
    (tmp_path / "held.py").write_text(HELD)
    command = [sys.executable, "held.py", str(ROOT / "examples/scenes/moving_shapes.py"), str(worlds)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["0"]
    assert "Traceback" not in done.stderr
    assert "ignored" not in done.stderr
