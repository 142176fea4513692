"""WebDataset and Parquet, read by `webdataset` and Hugging Face `datasets`, which the Python that
USDSDG_READERS_PYTHON names may have (see `readers/shards.py`). Parquet needs pyarrow in this one, too.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.soak.formats import readers
from tests.soak.formats.scene import Wanted, make
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats import webdataset
from usdsdg.verify import verify

_SPLITS = {"splits": {"train": 0.8, "val": 0.2}, "masks": True, "shard_samples": 50}
WANTED = {
    "webdataset": Wanted("WebDatasetWriter", {**_SPLITS, "depth": True, "shard_megabytes": 2.0}, 2),
    "parquet": Wanted("ParquetWriter", {**_SPLITS, "row_group_samples": 20, "shard_megabytes": 2.0}, 2),
}


def rows(folder: Path, frames: int) -> Iterator[tuple[str, str, bool]]:
    """Yield what the readers and `usdsdg verify` say of the scene."""
    make(folder, WANTED, frames=frames)
    for name in WANTED:
        faults = verify(folder / name).faults
        shards = sorted(path.name for path in (folder / name).rglob("*-0*.*"))
        yield f"{name}: usdsdg verify", f"{len(shards)} shards, {len(faults)} faults{faults[:1] or ''}", not faults
    expected = folder / "expected.json"
    expected.write_text(json.dumps(_samples(folder / "webdataset")))
    yield from readers.rows_of("shards", folder, expected)


def _samples(folder: Path) -> dict[str, list[Any]]:
    """Return the samples by split, as `usdsdg verify` has found them equal to the records of frames."""
    data, found = Folder(folder), {}
    for seen in webdataset.read(data, data.files):
        complete = seen.complete()
        stored, image = complete.extra["sample"], complete.colors[0].image
        ids = stored.instances.astype(np.uint16)
        sample = [seen.frame, zlib.crc32(image), list(stored.objects), zlib.crc32(ids)]
        found.setdefault(stored.file.split("-")[0], []).append(sample)
    return found
