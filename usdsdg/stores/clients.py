"""Clients of object stores, from obstore: credentials from the environment, profiles, and roles of the machine."""

from __future__ import annotations

import json
import os
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from usdsdg.errors import StoreError, Unsupported
from usdsdg.stores.addresses import Address
from usdsdg.stores.aws_profile import aws_profile

if TYPE_CHECKING:
    from obstore.store import ObjectStore as Client

CONNECT_SECONDS = 10
# For one request with its body: 8 MB parts on slow lines, and servers that accept a connection and never answer.
ANSWER_SECONDS = 60
PAUSE_SECONDS = (0.1, 2.0)  # before the first and the last attempt of one request

_memory: dict[str, Client] = {}


def connect(address: Address, *, region: str | None, endpoint_url: str | None, retries: int) -> Client:
    """Return a client of the bucket, server or memory of an address; nothing is sent.

    retries: how often the client itself repeats a request, within some seconds.

    Raises:
        Unsupported: obstore is not installed.
        StoreError: an option in the environment is wrong.
    """
    try:
        from obstore import exceptions, store
    except ImportError as error:
        raise Unsupported(
            f"{address.url} needs obstore, which is not installed ({error}): pip install 'usdsdg[stores]'."
        ) from error
    common: dict[str, Any] = {"client_options": _client_options(), "retry_config": _retry_config(retries)}
    try:
        if address.kind == "memory":
            return _memory.setdefault(address.host, store.MemoryStore())
        if address.kind == "http":
            return store.HTTPStore.from_url(address.host, **common)
        if address.kind == "gs":
            return store.GCSStore(address.host, **common, **_google(endpoint_url))
        if address.kind == "az":
            return store.AzureStore(address.host, **common, **_azure(address, endpoint_url))
        return store.S3Store(address.host, **common, **_amazon(region, endpoint_url))
    except (exceptions.BaseError, OSError, ValueError) as error:
        text = str(error).split("Debug source")[0].strip()
        raise StoreError(f"{address.url} cannot be opened: {text}. Look at its name and your environment.") from error


def _amazon(region: str | None, endpoint_url: str | None) -> dict[str, Any]:
    options: dict[str, Any] = aws_profile()
    if region:
        options["region"] = region
    if endpoint_url:
        options["endpoint"] = endpoint_url
    return options


def _google(endpoint_url: str | None) -> dict[str, Any]:
    # The variable of Google's own libraries for an emulator.
    endpoint = endpoint_url or os.environ.get("STORAGE_EMULATOR_HOST")
    if not endpoint:
        return {}
    endpoint = endpoint if "://" in endpoint else f"http://{endpoint}"
    # With `skip_signature` alone, puts would still ask the machine's cloud for a token.
    nobody = {"client_email": "", "private_key": "", "private_key_id": ""}
    return {"config": {"service_account_key": json.dumps({"gcs_base_url": endpoint, "disable_oauth": True, **nobody})}}


def _azure(address: Address, endpoint_url: str | None) -> dict[str, Any]:
    options: dict[str, Any] = {}
    if address.account:
        options["account_name"] = address.account
    if endpoint_url:
        options["endpoint"] = endpoint_url
    return options


def _client_options() -> Any:
    return {
        "allow_http": True,
        "connect_timeout": timedelta(seconds=CONNECT_SECONDS),
        "read_timeout": timedelta(seconds=ANSWER_SECONDS),
        "timeout": timedelta(days=1),  # of a whole file
    }


def _retry_config(retries: int) -> Any:
    first, longest = (timedelta(seconds=each) for each in PAUSE_SECONDS)
    backoff = {"init_backoff": first, "max_backoff": longest, "base": 3}
    return {"max_retries": retries, "retry_timeout": timedelta(seconds=10), "backoff": backoff}
