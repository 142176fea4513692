"""Pictures inside of FBX files, which assimp-py does not give.

A binary file is a tree of records: where a record ends, how many properties of how many bytes it has, its name, its
properties, and the records below it. Those of pictures are `Objects/Video`, with the properties of `Content` as bytes
and of `RelativeFilename` and `Filename` as names.
"""

from __future__ import annotations

import base64
import binascii
import re
import struct
from collections.abc import Iterator
from typing import NamedTuple

_BINARY = b"Kaydara FBX Binary  \x00"
_HEADER = 27  # bytes, the last four of which are the version
_WIDE = 7500  # version from which on records have numbers of 64 bits
_VIDEO = re.compile(rb'^[ \t]*Video:[^{}\n]*"Clip"', re.MULTILINE)
_NAME = re.compile(rb'^[ \t]*(?:Relative)?File[nN]ame:[ \t]*"([^"\n]*)"', re.MULTILINE)
_CONTENT = re.compile(rb'^[ \t]*Content:[\s,]*((?:"[^"]*"[\s,]*)+)', re.MULTILINE)


class _Record(NamedTuple):
    name: bytes
    properties: tuple[int, int]  # where they begin and end
    end: int


def media(content: bytes) -> dict[str, bytes]:
    """Return the pictures inside of a file by the last part of their names, in lower case."""
    found = _of_binary(content) if content.startswith(_BINARY) else _of_text(content)
    return {_last(name): picture for name, picture in found if picture}


def _last(name: bytes) -> str:
    return name.decode("utf-8", "replace").replace("\\", "/").rsplit("/", 1)[-1].lower()


def _of_binary(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield names and pictures; nothing more where a record is damaged, of which assimp says what is wrong."""
    if len(content) < _HEADER:
        return
    is_wide = struct.unpack_from("<I", content, _HEADER - 4)[0] >= _WIDE
    for top in _records(content, _HEADER, len(content), is_wide):
        if top.name != b"Objects":
            continue
        for video in _records(content, top.properties[1], top.end, is_wide):
            if video.name != b"Video":
                continue
            below = list(_records(content, video.properties[1], video.end, is_wide))
            names = [_bytes_of(content, each) for each in below if each.name in (b"RelativeFilename", b"Filename")]
            for each in below:
                if each.name == b"Content" and (picture := _bytes_of(content, each)):
                    yield from ((name, picture) for name in names if name)


def _records(content: bytes, start: int, end: int, is_wide: bool) -> Iterator[_Record]:
    head = struct.Struct("<QQQB" if is_wide else "<IIIB")
    at = start
    while at + head.size <= end:
        behind, _, size, length = head.unpack_from(content, at)
        if behind == 0:  # the last of a list
            return
        first = at + head.size + length
        if not first + size <= behind <= end:
            return
        yield _Record(content[at + head.size : first], (first, first + size), behind)
        at = behind


def _bytes_of(content: bytes, record: _Record) -> bytes:
    """Return the bytes or the text that a record has as its first property; none of another kind."""
    first, end = record.properties
    if end - first < 5 or content[first : first + 1] not in (b"R", b"S"):
        return b""
    (size,) = struct.unpack_from("<I", content, first + 1)
    return content[first + 5 : first + 5 + size] if first + 5 + size <= end else b""


def _of_text(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    for video in _VIDEO.split(content)[1:]:
        given = _CONTENT.search(video)
        if given is None:
            continue
        try:
            picture = base64.b64decode(re.sub(rb'[\s",]', b"", given[1]), validate=True)
        except binascii.Error:
            continue
        yield from ((name, picture) for name in _NAME.findall(video[: given.start()]) if name)
