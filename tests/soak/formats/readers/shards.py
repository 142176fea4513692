"""Read shards with `webdataset` and Hugging Face `datasets`: `python shards.py ROWS.json FOLDER EXPECTED.json`.

It runs in a Python of its own, which has both, and torch; nothing here is of usdsdg. EXPECTED.json has the samples of
each split as the writer was given them: key, checksum of the picture, objects, and checksum of the image of ids.
"""

import json
import logging
import os
import sys
import tempfile
import warnings
import zlib
from pathlib import Path

import numpy as np

os.environ["HF_HOME"] = tempfile.mkdtemp()
os.environ["HF_HUB_OFFLINE"] = "1"


def main() -> None:
    where, folder, expected = sys.argv[1:]
    wanted = json.loads(Path(expected).read_text())
    rows = []
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        for read in (by_webdataset, by_datasets_tar, by_datasets_parquet):
            rows += [compared(f"{read.__doc__} {split}", read(Path(folder), split), wanted[split]) for split in wanted]
    texts = {f"{each.category.__name__}: {each.message}" for each in said if "usdsdg" in str(each.message)}
    rows.append(["warnings about the shards", "; ".join(sorted(texts)) or "none", not texts])
    rows += features(Path(folder))
    Path(where).write_text(json.dumps(rows))


def by_webdataset(folder: Path, split: str) -> list:
    """webdataset:"""
    import webdataset

    urls = [str(path) for path in sorted((folder / "webdataset").glob(f"{split}-*.tar"))]
    decoded = webdataset.WebDataset(urls, shardshuffle=False, empty_check=False).decode("rgb8")
    found = []
    for each in decoded:
        # Its decoder of images gives ids as colors; the bytes of the member are not touched.
        found.append([each["__key__"], checksum(each["png"]), each["json"]["objects"]])
        assert each["depth.npy"].shape == each["png"].shape[:2]
    return found


def by_datasets_tar(folder: Path, split: str) -> list:
    """datasets, of tars:"""
    from datasets import load_dataset

    files = {split: str(folder / "webdataset" / f"{split}-*.tar")}
    loaded = load_dataset("webdataset", data_files=files, split=split, streaming=False)
    return [
        [
            each["__key__"],
            checksum(np.array(each["png"])),
            each["json"]["objects"],
            checksum(np.array(each["instances.png"])),
        ]
        for each in loaded
    ]


def by_datasets_parquet(folder: Path, split: str) -> list:
    """datasets, of Parquet:"""
    from datasets import load_dataset

    # It finds the parts by the names of the files.
    loaded = load_dataset(str(folder / "parquet"), split={"val": "validation"}.get(split, split))
    found = []
    for each in loaded:
        listed = each["objects"]
        rows = [dict(zip(listed, values)) for values in zip(*listed.values())]
        found.append([each["key"], checksum(np.array(each["image"])), rows, checksum(np.array(each["instances"]))])
    return found


def features(folder: Path) -> list:
    """Return what `datasets` makes of the columns of Parquet."""
    from datasets import ClassLabel, Dataset, Image

    (first, *_) = sorted(str(path) for path in (folder / "parquet/data").glob("*.parquet"))
    known = Dataset.from_parquet(first).features
    category = known["objects"]["category"].feature
    is_right = isinstance(known["image"], Image) and isinstance(category, ClassLabel)
    return [["Dataset.from_parquet decodes images, and names classes", ", ".join(category.names), is_right]]


def checksum(image: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(image))


def compared(what: str, found: list, expected: list) -> list:
    """Compare samples in the order of their keys: datasets and shards keep it."""
    wrong = [key for key, *_ in found if key not in {each[0] for each in expected}]
    for mine, theirs in zip(found, expected):
        key, image, objects, *ids = mine
        same = [(float(a["visibility"]) - b["visibility"]) ** 2 < 1e-12 for a, b in zip(objects, theirs[2])]
        plain = [{name: value for name, value in each.items() if name != "visibility"} for each in objects]
        other = [{name: value for name, value in each.items() if name != "visibility"} for each in theirs[2]]
        if [key, image, plain, *ids] != [theirs[0], theirs[1], other, *theirs[3 : 3 + len(ids)]] or not all(same):
            wrong.append(key)
    count = sum(len(each[2]) for each in found)
    text = f"{len(found)} of {len(expected)} samples, {count} objects; different: {wrong[:3] or 'none'}"
    return [what, text, not wrong and len(found) == len(expected)]


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING)
    main()
