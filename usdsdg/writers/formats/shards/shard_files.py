"""Names of the files of WebDataset and Parquet datasets, and of what a sample has, for writers and readers."""

from __future__ import annotations

WEBDATASET, PARQUET = "WebDatasetWriter", "ParquetWriter"
INDEX = "index.json"  # of a WebDataset: classes, and the shards with the numbers of their samples
IMAGE, INSTANCES, DEPTH = "image", "instances", "depth"
# What a sample has beside its picture, and one of its objects; `objects` has a list for each.
FACTS = ("key", "frame", "view", "width", "height")
OBJECT = ("id", "category", "label", "bbox", "area", "visibility", "path")
# Members of a sample in a WebDataset, by what they are; that of the picture is its format.
MEMBERS = {INSTANCES: "instances.png", DEPTH: "depth.npy"}
JSON = "json"


def tar_of(split: str, number: int) -> str:
    """Return the file of a shard of a WebDataset."""
    return f"{split}-{number:06d}.tar"


def parquet_of(split: str, number: int) -> str:
    """Return the file of a shard of a Parquet dataset, which Hugging Face assigns to the split by its name."""
    return f"data/{split}-{number:05d}.parquet"
