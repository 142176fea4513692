"""Chunks of a recording whose ids follow from what they hold, not from the clock, so that runs repeat them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.stores.temporary import TemporaryFolder
from usdsdg.writers.formats.rerun.rerun_extra import rerun

APPLICATION = "usdsdg"
FRAME, TIME = "frame", "time"  # timelines
_ROW_ID, _CHUNK_ID = "rerun.controls.RowId", b"rerun:id"


@dataclass(frozen=True)
class Moment:
    """A frame of a recording: its number, and the time on the timeline [s]."""

    frame: int
    seconds: float


@dataclass(frozen=True)
class Logged:
    """What is logged at one entity. moment: None for what is true at all times."""

    path: str
    archetype: Any  # of rerun, one row
    moment: Moment | None


def chunks(logged: Sequence[Logged]) -> list[Any]:
    """Return a chunk for each that is logged in one frame, later ones above earlier ones."""
    return [_chunk(each, order) for order, each in enumerate(logged)]


def rrd_bytes(made: Sequence[Any], recording: str) -> bytes:
    """Return chunks as a file. recording: its id; the viewer opens files with the same id as one recording."""
    stream = rerun().chunk.LazyChunkStream.from_iter(made)
    with TemporaryFolder("rerun") as folder:
        file = folder / "frame.rrd"
        stream.write_rrd(file, application_id=APPLICATION, recording_id=recording)
        return file.read_bytes()


def _chunk(logged: Logged, order: int) -> Any:
    rr = rerun()
    moment, indexes = logged.moment, []
    if moment is not None:
        indexes = [rr.TimeColumn(FRAME, sequence=[moment.frame]), rr.TimeColumn(TIME, duration=[moment.seconds])]
    # Each batch of components is one row.
    columns = [
        rr.ComponentColumn(batch.component_descriptor(), batch, lengths=[len(batch.as_arrow_array())])
        for batch in logged.archetype.as_component_batches()
    ]
    return _identified(rr.chunk.Chunk.from_columns(logged.path, indexes, columns), moment, order)


def _identified(chunk: Any, moment: Moment | None, order: int) -> Any:
    """Return a chunk with ids of its own: rerun's are made of the clock and of random numbers."""
    import pyarrow

    batch = chunk.to_record_batch()
    # What is static has the same ids in all frames: the viewer keeps one.
    number = 0 if moment is None else moment.frame + 1
    digest = hashlib.blake2b(f"{chunk.entity_path} {number} {order}".encode(), digest_size=16)
    row = number.to_bytes(8, "big") + order.to_bytes(4, "big") + digest.digest()[:4]
    place = batch.schema.get_field_index(_ROW_ID)
    rows = pyarrow.array([row], type=batch.schema.field(place).type)
    metadata = {**batch.schema.metadata, _CHUNK_ID: b"chunk_" + digest.hexdigest().encode()}
    batch = batch.set_column(place, batch.schema.field(place), rows).replace_schema_metadata(metadata)
    (made,) = rerun().chunk.Chunk.from_record_batch(batch)
    return made
