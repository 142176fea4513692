"""A glTF 2 document in memory: its JSON, its buffers, and the arrays of its accessors."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.errors import AssetUnreadable

_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class Document:
    """What a .glb or .gltf file holds; arrays can be added, and all of it saved as the bytes of one GLB file."""

    def __init__(self, file: Path, beside: Callable[[str], bytes]) -> None:
        """Read a file; `beside` gives the bytes of the files that it names.

        Raises:
            AssetUnreadable: the file is cut off, or no glTF.
        """
        content, own = file.read_bytes(), None
        if content[:4] == b"glTF":
            content, own = _chunks(file, content)
        self.json: dict[str, Any] = json.loads(content)
        if not isinstance(self.json, dict):
            raise AssetUnreadable(f"{file} is no glTF file: its JSON is not an object")
        version = str(self.json.get("asset", {}).get("version", "2.0"))
        if not version.startswith("2"):
            raise AssetUnreadable(f"{file} is glTF {version}; only glTF 2 is read, so export it again")
        self._views = bytearray()
        starts = []
        for buffer in self.json.get("buffers", []):
            self._views += b"\0" * (-len(self._views) % 4)
            starts.append(len(self._views))
            uri = buffer.get("uri")
            self._views += (own or b"") if uri is None else _bytes_of(uri, beside)
        for view in self.json.get("bufferViews", []):
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
            view["buffer"] = 0

    def array(self, index: int) -> np.ndarray:
        """Return the values (N, C) of an accessor: floats, or integers that are not normalized."""
        entry = self.json["accessors"][index]
        kind, size, count = np.dtype(_KINDS[entry["componentType"]]), _SIZES[entry["type"]], int(entry["count"])
        values = np.zeros((count, size), kind)
        if "bufferView" in entry:
            values = self._strided(entry["bufferView"], entry.get("byteOffset", 0), kind, (count, size))
        if sparse := entry.get("sparse"):
            at, new, number = sparse["indices"], sparse["values"], int(sparse["count"])
            rows = self._strided(
                at["bufferView"], at.get("byteOffset", 0), np.dtype(_KINDS[at["componentType"]]), (number, 1)
            )
            values[rows[:, 0]] = self._strided(new["bufferView"], new.get("byteOffset", 0), kind, (number, size))
        return self.normalized(values, index)

    def normalized(self, values: np.ndarray, index: int) -> np.ndarray:
        """Return integers as the floats that they stand for, where an accessor says that they do."""
        entry = self.json["accessors"][index]
        kind = np.dtype(_KINDS[entry["componentType"]])
        if entry.get("normalized") and kind.kind in "iu":
            return np.maximum(values.astype(np.float32) / np.iinfo(kind).max, -1.0)
        return values

    def floats(self, index: int) -> np.ndarray:
        """Return the values of an accessor as float32."""
        return self.array(index).astype(np.float32)

    def add(self, values: np.ndarray) -> int:
        """Append an array (N, C) of float32 or uint32 and return its accessor."""
        kind = {"f": 5126, "u": 5125}[values.dtype.kind]
        self._views += b"\0" * (-len(self._views) % 4)
        content = np.ascontiguousarray(values).tobytes()
        view = {"buffer": 0, "byteOffset": len(self._views), "byteLength": len(content)}
        self._views += content
        self.json.setdefault("bufferViews", []).append(view)
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
        entry = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": kind, "count": len(values)}
        self.json["accessors"].append({**entry, "type": shape})
        return len(self.json["accessors"]) - 1

    def bytes_of_view(self, index: int) -> bytes:
        """Return the bytes of a buffer view."""
        view = self.json["bufferViews"][index]
        return bytes(self._views[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])

    def glb(self) -> bytes:
        """Return the bytes of a GLB file with all buffers inside."""
        self.json["buffers"] = [{"byteLength": len(self._views)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        body = bytes(self._views) + b"\0" * (-len(self._views) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _strided(self, view: int, offset: int, kind: np.dtype, shape: tuple[int, int]) -> np.ndarray:
        entry = self.json["bufferViews"][view]
        start, row = entry["byteOffset"] + offset, kind.itemsize * shape[1]
        stride = entry.get("byteStride") or row
        if shape[0] and start + stride * (shape[0] - 1) + row > len(self._views):
            raise ValueError("an accessor reaches beyond its buffer")
        # A copy, since buffers grow, of these values alone: files have thousands of accessors.
        return np.ndarray(shape, kind, self._views, start, (stride, kind.itemsize)).copy()


def _chunks(file: Path, content: bytes) -> tuple[bytes, bytes]:
    """Return the JSON and the binary chunk of a GLB file."""
    version, length = struct.unpack_from("<II", content.ljust(12, b"\0"), 4)
    if version != 2:
        raise AssetUnreadable(f"{file} is glTF {version}; only glTF 2 is read, so export it again")
    if length > len(content):
        raise AssetUnreadable(f"{file} cannot be read as GLB: it is cut off after {len(content)} of {length} bytes")
    found, at = {}, 12
    while at + 8 <= length:
        size, name = struct.unpack_from("<I4s", content, at)
        found.setdefault(name, content[at + 8 : at + 8 + size])
        at += 8 + size
    if b"JSON" not in found:
        raise AssetUnreadable(f"{file} cannot be read as GLB: it has no JSON")
    return found[b"JSON"], found.get(b"BIN\0", b"")


def _bytes_of(uri: str, beside: Callable[[str], bytes]) -> bytes:
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2])
        except binascii.Error as error:
            raise ValueError(f"a buffer inside the file is not base64: {error}") from error
    return beside(uri)
