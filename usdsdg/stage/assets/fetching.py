"""Assets at URLs of their own, outside of the assets root: they come to this machine with all that they refer to."""

from __future__ import annotations

import os

from usdsdg import errors
from usdsdg.stage.assets import root, url

VARIABLE = "USDSDG_FETCH_ASSETS"  # "0": nothing is fetched but what lies under the assets root

_SERVERS = ("http", "https")
_BUCKETS = ("s3", "gs", "az")


def fetched(text: str) -> str | None:
    """Return the file on this machine that a URL of a server or a bucket stands for, which comes once.

    None if it is of another kind, or a web address of `/Isaac/...` or `/NVIDIA/...`, which an assets root has.

    Raises:
        AssetNotFound: there is no such file, or nobody may read it without credentials.
        AssetError: the server does not answer again and again, the bucket is missing, or credentials are wrong.
        Unsupported: obstore is not installed.
    """
    scheme = url.scheme_of(text)
    if scheme not in (*_SERVERS, *_BUCKETS) or os.environ.get(VARIABLE) == "0":
        return None
    if scheme in _SERVERS and url.below_top_folders(url.path_of(text)):
        return None
    site, path = _site_and_path(url.normalized(text))
    if not path or {"", ".", ".."} & set(path.split("/")):
        return None
    mirror = root.site_mirror(site)
    if mirror is None:
        return None
    if not mirror.fetch(path):
        error = errors.AssetNotFound(f"no file for {text}: {site} has no {path}, or denies access to it.")
        error.looked_for = [f"{site} has no {path}, or denies access to it"]
        raise error
    return os.path.join(mirror.folder, *path.split("/"))


def _site_and_path(whole: str) -> tuple[str, str]:
    """Split `https://host/a%20b` to `https://host` and `a b`; keys of buckets are as they are written."""
    scheme, _, rest = whole.partition("://")
    host, _, key = rest.partition("/")
    path = url.path_of(whole) if scheme in _SERVERS else key
    return f"{scheme}://{host}", path.strip("/")
