"""Read COCO files with pycocotools, and score them as predictions of themselves.

`python coco.py ROWS.json DATASET PANOPTICAPI`
It runs in a Python of its own, which has pycocotools and scipy; PANOPTICAPI is a checkout of cocodataset/panopticapi.
Nothing here is of usdsdg.
"""

import contextlib
import io
import json
import sys
import warnings
from pathlib import Path

import numpy as np


def main() -> None:
    where, dataset, panopticapi = sys.argv[1:4]
    rows = []
    for path in sorted(Path(dataset).glob("annotations/instances_*.json")):
        rows += instances(path)
        rows += panoptic(path.parent, path.stem.removeprefix("instances_"), panopticapi)
    Path(where).write_text(json.dumps(rows))


def instances(path: Path) -> list:
    """Load the file, and score its boxes, masks and keypoints."""
    from pycocotools import mask as masks
    from pycocotools.coco import COCO

    with warnings.catch_warnings(record=True) as said, contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", DeprecationWarning)  # of its own arrays
        truth = COCO(str(path))
        own = [truth.annToMask(each) for each in truth.anns.values()]
    covered = [(int(mask.sum()), int(each["area"])) for mask, each in zip(own, truth.anns.values())]
    exact = sum(a == b for a, b in covered)
    texts = {str(each.message) for each in said} or "no warning"
    found = f"{len(truth.imgs)} pictures, {len(own)} objects; {texts}"
    rows = [[f"pycocotools loads {path.name}", found, not said and bool(own)]]
    is_polygon = isinstance(next(iter(truth.anns.values()))["segmentation"], list)
    area = "at least the area (holes are filled)" if is_polygon else "the area"
    right = all(a >= b if is_polygon else a == b for a, b in covered)
    rows.append([f"{path.name}: pixels of masks are {area}", f"{exact} of {len(own)} equal", right])
    boxes = [masks.toBbox(truth.annToRLE(each)).tolist() == each["bbox"] for each in truth.anns.values()]
    rows.append([f"{path.name}: boxes are those of masks", f"{sum(boxes)} of {len(boxes)}", all(boxes)])
    most = max(len(own) for own in truth.imgToAnns.values())
    for kind in ("bbox", "segm"):
        score, recall = _scored(truth, list(truth.anns.values()), kind, most)
        rows.append([f"{path.name}: AP and AR of {kind}, maxDets {most}", f"{score}, {recall}", score == recall == 1.0])
    sigmas = truth.dataset["info"].get("keypoint_sigmas", {})
    for category in truth.cats.values():
        if "keypoints" in category:
            own = [each for each in truth.anns.values() if each["category_id"] == category["id"]]
            lengths = {len(each["keypoints"]) for each in own}
            rows.append(
                [
                    f"{path.name}: {category['name']}: numbers of keypoints",
                    f"{lengths}, {len(own)} objects",
                    lengths == {3 * len(category["keypoints"])},
                ]
            )
            own = [each for each in own if each["num_keypoints"]]
            score, recall = _scored(truth, own, "keypoints", most, category["id"], sigmas[category["name"]])
            rows.append(
                [
                    f"{path.name}: AP and AR of keypoints of {category['name']}",
                    f"{score}, {recall}",
                    score == recall == 1,
                ]
            )
    return rows


def _scored(truth, annotations, kind, most, category=None, sigmas=None):
    """Score annotations as predictions; return average precision and recall."""
    from pycocotools.cocoeval import COCOeval

    keys = ("image_id", "category_id", *{"bbox": ["bbox"], "segm": ["segmentation"]}.get(kind, ["keypoints", "bbox"]))
    with contextlib.redirect_stdout(io.StringIO()):
        found = [{key: each[key] for key in keys} | {"score": 1.0} for each in annotations]
        if kind == "segm":
            found = [each | {"segmentation": truth.annToRLE(own)} for each, own in zip(found, annotations)]
        predictions = truth.loadRes(found)
        if kind == "keypoints":  # loadRes takes boxes of keypoints for those of objects
            for each, own in zip(predictions.anns.values(), annotations):
                each.update(area=own["area"], bbox=own["bbox"])
        judged = COCOeval(truth, predictions, kind)
        judged.params.maxDets = [most] if kind == "keypoints" else [1, 10, most]
        if category is not None:
            judged.params.catIds = [category]
            judged.params.kpt_oks_sigmas = np.array(sigmas)
        judged.params.areaRng, judged.params.areaRngLbl = [[0, 1e10]], ["all"]
        judged.evaluate()
        judged.accumulate()
    precision, recall = (judged.eval[name] for name in ("precision", "recall"))
    return float(precision[..., -1][precision[..., -1] > -1].mean()), float(
        recall[..., -1][recall[..., -1] > -1].mean()
    )


def panoptic(folder: Path, split: str, checkout: str) -> list:
    """Score the segments with panopticapi, and compare their boxes and areas with the picture."""
    path = folder / f"panoptic_{split}.json"
    if not path.exists():
        return []
    sys.path.insert(0, checkout)
    from panopticapi.evaluation import pq_compute_single_core
    from panopticapi.utils import rgb2id
    from PIL import Image

    values, pictures = json.loads(path.read_text()), folder / f"panoptic_{split}"
    own, categories = values["annotations"], {each["id"]: each for each in values["categories"]}
    with contextlib.redirect_stdout(io.StringIO()):
        stat = pq_compute_single_core(0, [(each, each) for each in own], str(pictures), str(pictures), categories)
    # It divides by the number of classes, so that none of stuff is an error.
    seen = {bool(categories[number]["isthing"]) for number in stat.pq_per_cat}
    kinds = {"all": None} | {"things" if kind else "stuff": kind for kind in sorted(seen)}
    found = {name: float(stat.pq_average(categories, isthing=kind)[0]["pq"]) for name, kind in kinds.items()}
    wrong = total = 0
    for each in own:
        ids = rgb2id(np.array(Image.open(pictures / each["file_name"])))
        assert {int(number) for number in np.unique(ids)} - {0} == {one["id"] for one in each["segments_info"]}
        for one in each["segments_info"]:
            rows, columns = np.nonzero(ids == one["id"])
            box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
            wrong, total = wrong + (one["bbox"] != box or one["area"] != len(rows)), total + 1
    return [
        [f"{path.name}: PQ by panopticapi", str(found), set(found.values()) == {1.0}],
        [f"{path.name}: boxes and areas are those of the picture", f"{total - wrong} of {total}", not wrong],
    ]


if __name__ == "__main__":
    main()
