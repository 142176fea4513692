"""Tar archives of samples, with the same bytes for the same samples."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Iterable, Mapping
from typing import NamedTuple


class TarSample(NamedTuple):
    """The files of one sample: bytes by extension."""

    key: str
    members: Mapping[str, bytes]

    @property
    def size(self) -> int:
        """Bytes in an archive: a header for each member, whose content fills whole blocks."""
        block = tarfile.BLOCKSIZE
        return sum(block + -(-len(data) // block) * block for data in self.members.values())


def archive(samples: Iterable[TarSample]) -> bytes:
    """Return an archive in which the members of a sample, KEY.EXTENSION, follow each other.

    Members have no owner and no time, so that an archive depends on the samples alone.
    """
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for each in samples:
            for extension, data in each.members.items():
                member = tarfile.TarInfo(f"{each.key}.{extension}")
                member.size, member.mode, member.mtime = len(data), 0o644, 0
                tar.addfile(member, io.BytesIO(data))
    return buffer.getvalue()
