"""URLs of stores, taken apart: `s3://bucket/runs/7`, `https://host/files`, `file:///data`, and plain folders."""

from __future__ import annotations

import os
import re
from typing import NamedTuple
from urllib.parse import unquote

from usdsdg.errors import StoreError

# Scheme -> the kind of store that it names.
BUCKETS = {"s3": "s3", "s3a": "s3", "gs": "gs", "gcs": "gs", "az": "az", "azure": "az", "abfs": "az", "abfss": "az"}
SERVERS = ("http", "https")

_URL = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/{1,2}(.*)", re.DOTALL)  # two letters at least: C:/ is a drive
_DRIVE_IN_URL = re.compile(r"/[A-Za-z]:(/|$)")


class Address(NamedTuple):
    """Where a store is."""

    kind: str  # "folder", "s3", "gs", "az", "http" or "memory"
    host: str  # the bucket, or scheme and host of a server; "" of a folder
    path: str  # the folder; of others the prefix, without slashes at its ends
    account: str = ""  # of Azure, where the URL names it

    @property
    def url(self) -> str:
        """The URL of the store, without a slash at its end; of a folder its path."""
        if self.kind == "folder":
            return self.path
        start = self.host if self.kind == "http" else f"{self.kind}://{self.host}"
        return f"{start}/{self.path}".rstrip("/")


def is_url(text: str | os.PathLike) -> bool:
    """Whether a text names a store by a URL, not a folder by its path; `C:/data` and `C:\\data` are paths."""
    return isinstance(text, str) and _URL.fullmatch(text) is not None


def address_of(where: str | os.PathLike) -> Address:
    """Return where a store is; keys of buckets are taken as they are written, paths of file URLs are decoded.

    Raises:
        StoreError: the URL is of another kind, names no bucket, or a part of its path is "..".
    """
    text = os.fspath(where)
    found = _URL.fullmatch(text)
    if found is None:
        return Address("folder", "", text)
    scheme, rest = found[1].lower(), found[2]
    if scheme == "file":
        return Address("folder", "", _path_of_file_url(text))
    host, _, path = rest.partition("/")
    if scheme not in BUCKETS and scheme not in (*SERVERS, "memory"):
        known = ", ".join(f"{each}://" for each in ("s3", "gs", "az", "https", "http", "file"))
        raise StoreError(f"{text} is a URL of a kind that is not known; there are {known} and folders.")
    parts = [part for part in path.split("/") if part]
    if not host or {".", ".."} & set(parts):
        raise StoreError(f"{text} names no place in a store; give a URL such as {scheme}://name/folder, without '..'.")
    prefix = "/".join(parts)
    if scheme in SERVERS:
        return Address("http", f"{scheme}://{host}", prefix)
    if scheme.startswith("abfs") and "@" in host:  # abfss://container@account.dfs.core.windows.net/path
        container, _, server = host.partition("@")
        return Address("az", container, prefix, server.split(".")[0])
    return Address(BUCKETS.get(scheme, scheme), host, prefix)


def _path_of_file_url(text: str) -> str:
    """Return the path of `file:///data/a%20b`, `file://localhost/data`, `file:/data` or `file:///C:/data`."""
    rest = text.partition(":")[2]
    if rest.startswith("//"):
        host, slash, path = rest[2:].partition("/")
        if host not in ("", "localhost"):
            raise StoreError(f"{text} names the machine {host!r}; give a path of this one, as in file:///data.")
        rest = slash + path
    path = unquote(rest)
    return path[1:] if _DRIVE_IN_URL.match(path) else path
