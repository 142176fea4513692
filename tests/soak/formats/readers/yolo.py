"""Check YOLO datasets with ultralytics: `python yolo.py ROWS.json FOLDER SIZE TASK...`, each in FOLDER/TASK.

It runs in a Python of its own, which has ultralytics and torch; nothing here is of usdsdg. Every label file goes
through ultralytics' own check, every split through its dataset, and its validators score the ground truth as a
prediction.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from heard import Heard

os.environ["YOLO_CONFIG_DIR"] = tempfile.mkdtemp()
os.environ["YOLO_OFFLINE"] = "1"
# Of perfect predictions it makes 0.995: precision is interpolated to nothing at a recall of one.
PERFECT = 0.9949
BOX_AND_MORE = {"detect": (), "segment": ("masks",), "obb": (), "pose": ("keypoints",)}


def main() -> None:
    where, folder, size, *tasks = sys.argv[1:]
    rows = [row for task in tasks for row in rows_of(Path(folder) / task, task, int(size))]
    Path(where).write_text(json.dumps(rows))


def rows_of(folder: Path, task: str, size: int) -> list:
    """Read all splits of a dataset."""
    from ultralytics.cfg import get_cfg
    from ultralytics.data.build import build_yolo_dataset
    from ultralytics.data.utils import check_det_dataset
    from ultralytics.utils import LOGGER

    heard = Heard()
    LOGGER.addHandler(heard)
    try:
        data = check_det_dataset(str(folder / "data.yaml"), autodownload=False)
        options = {"task": task, "imgsz": size, "overlap_mask": False, "mask_ratio": 1, "rect": False, "plots": False}
        config = get_cfg(overrides=options)
        rows = []
        for split in ("train", "val"):
            rows.append(checked(task, data, split))
            dataset = build_yolo_dataset(config, data[split], 1, data, mode="val", stride=32)
            rows += scored(task, split, dataset, data, config)
    finally:
        LOGGER.removeHandler(heard)
    rows.append(
        [f"{task}: warnings of ultralytics", "; ".join(sorted(set(heard.texts)))[:300] or "none", not heard.texts]
    )
    return rows


def checked(task: str, data: dict, split: str) -> list:
    """Check every label file of a split."""
    from ultralytics.data.utils import IMG_FORMATS, img2label_paths, verify_image_label

    images = sorted(str(path) for path in Path(data[split]).iterdir() if path.suffix[1:] in IMG_FORMATS)
    points, dimensions = data.get("kpt_shape", (0, 0))
    objects = missing = empty = corrupt = 0
    said = set()
    for image, labels in zip(images, img2label_paths(images), strict=True):
        found = verify_image_label((image, labels, "", task == "pose", data["nc"], points, dimensions, False))
        objects += 0 if found[1] is None else len(found[1])
        missing, empty, corrupt = missing + found[5], empty + found[7], corrupt + found[8]
        said |= {found[9]} - {""}
    text = f"{len(images)} pictures, {objects} objects, {empty} empty, {missing} missing, {corrupt} corrupt"
    return [
        f"{task}: verify_image_label of {split}",
        f"{text}; {sorted(said)[:3] or 'no message'}",
        not (missing or corrupt or said),
    ]


def scored(task: str, split: str, dataset: object, data: dict, config: object) -> list:
    """Score the ground truth as a prediction, by the validator of the task."""
    import torch
    from ultralytics.data.dataset import YOLODataset
    from ultralytics.models.yolo.detect import DetectionValidator
    from ultralytics.models.yolo.obb import OBBValidator
    from ultralytics.models.yolo.pose import PoseValidator
    from ultralytics.models.yolo.segment import SegmentationValidator
    from ultralytics.utils import ops

    kinds = {"detect": DetectionValidator, "segment": SegmentationValidator, "obb": OBBValidator, "pose": PoseValidator}
    validator = kinds[task](args=vars(config))
    validator.device, validator.data, validator.is_custom_json, validator.build_gdict = (
        torch.device("cpu"),
        data,
        False,
        False,
    )
    validator.seen, validator.metrics.names = 0, data["names"]
    if task == "segment":
        validator.process = ops.process_mask_native
    if task == "pose":
        validator.kpt_shape = data["kpt_shape"]
        validator.sigma = np.ones(validator.kpt_shape[0]) / validator.kpt_shape[0]
    unmatched, objects = set(), 0
    for index in range(len(dataset)):
        batch = YOLODataset.collate_fn([dataset[index]])
        batch |= {name: batch[name].float() for name in ("img", *BOX_AND_MORE[task])}
        if task == "pose":
            batch = _with_keypoints(batch)
        truth = validator._prepare_batch(0, {key: _copied(value) for key, value in batch.items()})
        prediction = {name: truth[name] for name in ("cls", "bboxes", *BOX_AND_MORE[task])}
        prediction["conf"] = torch.ones(len(truth["cls"]))
        objects += len(truth["cls"])
        for name, matched in validator._process_batch(prediction, truth).items():
            if not matched.all():
                unmatched.add(f"{name} in {Path(batch['im_file'][0]).name}")
        validator.update_metrics([prediction], batch)
    validator.metrics.process(save_dir=Path(tempfile.gettempdir()), plot=False)
    scores = {name: float(value) for name, value in validator.metrics.results_dict.items() if "mAP" in name}
    text = ", ".join(f"{name} {value:.4f}" for name, value in scores.items())
    is_right = not unmatched and objects > 0 and min(scores.values()) >= PERFECT
    return [
        [
            f"{task}: ground truth of {split} as prediction",
            f"{text}; unmatched: {sorted(unmatched)[:3] or 'none'}",
            is_right,
        ]
    ]


def _with_keypoints(batch: dict) -> dict:
    """Leave out objects without a keypoint in the picture: their similarity is 0 by definition; COCO ignores them."""
    known = (batch["keypoints"][..., 2] > 0).any(dim=1)
    return batch | {name: batch[name][known] for name in ("cls", "bboxes", "batch_idx", "keypoints")}


def _copied(value: object) -> object:
    return value.clone() if hasattr(value, "clone") else value


if __name__ == "__main__":
    main()
