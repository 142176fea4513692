"""What a recording holds, apart from the order of metadata, in which Rerun writes equal recordings differently."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from usdsdg.writers.formats.rerun.rerun_extra import rerun

SUFFIX = ".rrd"


def content(file: Path) -> dict[str, tuple[Any, ...]]:
    """Return what is in a file, by ids of chunks: its metadata, and the name, metadata and values of each column.

    Raises:
        Unsupported: Rerun is not installed.
        ValueError: the file is no recording.
    """
    try:
        chunks = rerun().chunk.RrdReader(file).stream().to_chunks()
    except RuntimeError as error:
        raise ValueError(str(error)) from error
    return {str(chunk.id): _columns(chunk.to_record_batch()) for chunk in chunks}


def _columns(batch: Any) -> tuple[Any, ...]:
    columns = zip(batch.schema, batch.columns, strict=True)
    found = [(field.name, dict(field.metadata or {}), column.to_pylist()) for field, column in columns]
    return dict(batch.schema.metadata), sorted(found, key=lambda column: column[0])
