"""Opens stores by URL or folder."""

from __future__ import annotations

import os

from usdsdg.stores.addresses import address_of
from usdsdg.stores.folder import FolderStore
from usdsdg.stores.object_store import ObjectStore
from usdsdg.stores.store import Store


def open_store(
    where: str | os.PathLike,
    *,
    region: str | None = None,
    endpoint_url: str | None = None,
    retry_seconds: float | None = None,
) -> Store:
    """Return the store at a URL or in a folder; neither folder nor bucket is made or asked for.

    where: a folder, or a URL: "s3://bucket/prefix", "gs://bucket/prefix", "az://container/prefix", "https://host/path"
        (read only), "file:///folder", "memory://name" (of this process). Keys are not percent-encoded.
    region, endpoint_url: of a bucket, in place of what the environment says.
    retry_seconds: how long a store that does not answer is asked again; default USDSDG_STORE_RETRY_SECONDS or 120.

    Raises:
        StoreError: the URL names no store, or its options in the environment are wrong.
        Unsupported: the URL needs obstore, which is not installed.
    """
    address = address_of(where)
    if address.kind == "folder":
        return FolderStore(address.path)
    return ObjectStore(address, region=region, endpoint_url=endpoint_url, retry_seconds=retry_seconds)
