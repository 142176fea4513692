"""Google's and Azure's clients: what they ask, and what they make of the words in which those refuse."""

import pytest

from tests.stores.servers import FailingProxy, only_ours
from usdsdg.errors import OutputNotWritable, StoreError
from usdsdg.stores import open_store


@pytest.fixture
def proxy(monkeypatch, tmp_path):
    only_ours(monkeypatch, str(tmp_path / "none"))
    with FailingProxy(1) as running:
        monkeypatch.setenv("STORAGE_EMULATOR_HOST", running.url.removeprefix("http://"))
        monkeypatch.setenv("AZURE_STORAGE_ACCOUNT_NAME", "lab")
        monkeypatch.setenv("AZURE_STORAGE_ACCOUNT_KEY", "b2YtdGhlLXRlc3Q=")
        yield running


def opened(url, proxy):
    return open_store(url, endpoint_url=proxy.url if url.startswith("az") else None)


@pytest.mark.parametrize(
    ("url", "fate", "reason"),
    [
        ("gs://bucket/p", "404 NoSuchBucket", "no such bucket; make it"),
        ("gs://bucket/p", "403 AccessDenied", "Storage Object User"),
        ("gs://bucket/p", "401 AuthenticationRequired", "GOOGLE_APPLICATION_CREDENTIALS"),
        ("az://box/p", "404 ContainerNotFound", "no such bucket; make it"),
        ("az://box/p", "403 AuthenticationFailed", "AZURE_STORAGE_ACCOUNT_KEY"),
        ("az://box/p", "403 AuthorizationPermissionMismatch", "Storage Blob Data Contributor"),
    ],
)
def test_refusals_are_told_at_once(proxy, url, fate, reason):
    proxy.fate = lambda *_: fate
    store = opened(url, proxy)
    for call in (store.put, store.put_if_absent):
        with pytest.raises(OutputNotWritable, match=reason):
            call("a b", b"1")
    with pytest.raises(StoreError, match=reason):
        list(store.list())
    assert len(proxy.seen) == 3
    assert all("a%20b" in target or "prefix=p" in target for _, target, _ in proxy.seen)


@pytest.mark.parametrize("url", ["gs://bucket", "az://box"])
@pytest.mark.parametrize("fate", ["412 ConditionNotMet", "409 BlobAlreadyExists"])
def test_a_file_that_is_there_is_not_put(proxy, url, fate):
    proxy.fate = lambda *_: fate
    assert opened(url, proxy).put_if_absent("x", b"1") is False
    assert len(proxy.seen) == 1
