"""Tar archives of samples, with the same bytes for the same samples."""

from __future__ import annotations

import base64
import tarfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from usdsdg.writers.formats.shards import shard_files as files
from usdsdg.writers.formats.shards.shards import Shards
from usdsdg.writers.spool import Records


class TarSample(NamedTuple):
    """The files of one sample: bytes by extension."""

    key: str
    members: Mapping[str, bytes]

    @property
    def size(self) -> int:
        """Bytes in an archive: a header for each member, whose content fills whole blocks."""
        block = tarfile.BLOCKSIZE
        return sum(block + -(-len(data) // block) * block for data in self.members.values())

    def record(self) -> dict[str, Any]:
        """Return it as a spool has it."""
        return {
            "key": self.key,
            "members": {name: base64.b64encode(data).decode() for name, data in self.members.items()},
        }

    @classmethod
    def of_record(cls, record: Mapping[str, Any]) -> TarSample:
        """Return the sample of a record."""
        return cls(record["key"], {name: base64.b64decode(data) for name, data in record["members"].items()})


class TarShards(Shards):
    """Shards of a WebDataset. A record has the "key" of a sample, and the bytes of its "members" in Base64."""

    @staticmethod
    def path_of(split: str, number: int) -> str:
        return files.tar_of(split, number)

    @staticmethod
    def content(records: Records) -> Iterable[bytes]:
        return Archive(lambda: map(TarSample.of_record, records))


class Archive:
    """The bytes of an archive in which the members of a sample, KEY.EXTENSION, follow each other, a member at a time.

    Members have no owner and no time, so that an archive depends on the samples alone.
    """

    def __init__(self, samples: Callable[[], Iterable[TarSample]]) -> None:
        self._samples = samples

    def __iter__(self) -> Iterator[bytes]:
        size = 0
        for each in self._samples():
            size += each.size
            for extension, data in each.members.items():
                member = tarfile.TarInfo(f"{each.key}.{extension}")
                member.size, member.mode, member.mtime = len(data), 0o644, 0
                yield member.tobuf(tarfile.USTAR_FORMAT)
                yield data
                yield bytes(-len(data) % tarfile.BLOCKSIZE)
        # Two empty blocks end an archive, which fills whole records.
        end = 2 * tarfile.BLOCKSIZE
        yield bytes(end + -(size + end) % tarfile.RECORDSIZE)
