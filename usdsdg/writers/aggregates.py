"""The aggregate files of a dataset, made again of the spools beside it: after parts were joined, or a run went on."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from usdsdg.errors import UsdsdgError, WriterError
from usdsdg.session.session import current
from usdsdg.writers import spool
from usdsdg.writers.aggregate import Aggregate
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.store import StoreBackend
from usdsdg.writers.journal.places.place import Place, StorePlace
from usdsdg.writers.journal.run import get_run

# The module of each kind of aggregate; spools name kinds, and a file does not decide what is imported.
_FORMATS = "usdsdg.writers.formats"
MODULES = {
    "CocoFiles": f"{_FORMATS}.coco.coco_file",
    "Scene": f"{_FORMATS}.bop.bop_tables",
    "ModelTables": f"{_FORMATS}.bop.bop_tables",
    "CvatFile": f"{_FORMATS}.cvat.cvat_xml",
    "ImageSets": f"{_FORMATS}.voc.image_sets",
    "ImageSet": f"{_FORMATS}.kitti.image_sets",
    "Clip": f"{_FORMATS}.cosmos.clips",
    "TarShards": f"{_FORMATS}.shards.tar_shard",
    "ParquetShards": f"{_FORMATS}.shards.parquet_shard",
    "SampleIndex": f"{_FORMATS}.shards.sample_index",
    "TrainList": f"{_FORMATS}.ycb_video.ycb_list",
}


def write_all(place: Place, spools: Path) -> None:
    """Write the aggregate files of all spools below `spools`.

    Raises:
        WriterError: a spool is damaged, or of a kind that this version does not know.
    """
    backend = StoreBackend.at(place) if isinstance(place, StorePlace) else DiskBackend(place.path)
    backend.ends_run = True
    for path in sorted(spools.rglob(f"*{spool.SUFFIX}")):
        write_spool(path, backend)


def write_spool(path: Path, backend: BaseBackend) -> None:
    """Write the aggregate files of a spool, and wait until they are written; errors are those of `write_all`."""
    with _sound(path) as of_kind:
        of_kind.schedule(spool.read(path), backend)
        backend.wait_until_done()


def paths_of(path: Path) -> list[str]:
    """Return the paths of the files that `write_spool` writes; errors are those of `write_all`."""
    with _sound(path) as of_kind:
        return of_kind.paths(spool.read(path))


@contextmanager
def _sound(path: Path) -> Iterator[type[Aggregate]]:
    """Give what makes the files of a spool; records that it cannot make any of are a WriterError."""
    kind = spool.kind_of(path)
    if kind not in MODULES:
        raise WriterError(f"{path}: files of the kind {kind!r} are not known to this version of usdsdg.")
    try:
        yield getattr(importlib.import_module(MODULES[kind]), kind)
    except UsdsdgError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise WriterError(
            f"{path}: its records are not such as {kind} are made of ({type(error).__name__}: {error}); "
            "`usdsdg verify` tells which files are whole."
        ) from error


def finish_run(*, complete: bool) -> None:
    """Write what a run that went on has not written itself, and close its journals, once its files are written.

    complete: the run has come to its end.
    """
    run = get_run()
    if run.is_closed or run.is_copy:
        return
    run.follow_moved()
    if not run.is_part:
        for folder in run.folders:
            if folder.goes_on or run.aggregates_wait:
                write_all(folder.place, folder.aggregates)
        current().io_queue.wait_until_done()
    run.close(complete=complete)
