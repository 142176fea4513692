"""Where a store is, by URL or path; paths of Windows, too."""

import pytest

from usdsdg.errors import StoreError
from usdsdg.stores.addresses import address_of, is_url


@pytest.mark.parametrize(
    ("text", "kind", "host", "path", "url"),
    [
        ("s3://bucket", "s3", "bucket", "", "s3://bucket"),
        ("s3://bucket/", "s3", "bucket", "", "s3://bucket"),
        ("S3A://bucket/a//b c%20/", "s3", "bucket", "a/b c%20", "s3://bucket/a/b c%20"),
        ("gs://b/ü", "gs", "b", "ü", "gs://b/ü"),
        ("az://c/x#y?z", "az", "c", "x#y?z", "az://c/x#y?z"),
        ("https://host:8/a/b", "http", "https://host:8", "a/b", "https://host:8/a/b"),
        ("memory://m", "memory", "m", "", "memory://m"),
        ("file:///data/a%20b", "folder", "", "/data/a b", "/data/a b"),
        ("file://localhost/data", "folder", "", "/data", "/data"),
        ("file:/data", "folder", "", "/data", "/data"),
        ("file:///C:/out", "folder", "", "C:/out", "C:/out"),
        ("C:/out", "folder", "", "C:/out", "C:/out"),
        ("C:\\out\\x", "folder", "", "C:\\out\\x", "C:\\out\\x"),
        ("\\\\server\\share", "folder", "", "\\\\server\\share", "\\\\server\\share"),
        ("out/s3", "folder", "", "out/s3", "out/s3"),
        ("~/a", "folder", "", "~/a", "~/a"),
    ],
)
def test_addresses(text, kind, host, path, url):
    address = address_of(text)
    assert (address.kind, address.host, address.path, address.url) == (kind, host, path, url)
    assert is_url(text) == (kind != "folder" or text.startswith("file:"))


def test_azure_urls_of_hadoop_name_the_account():
    address = address_of("abfss://container@account.dfs.core.windows.net/a/b")
    assert (address.kind, address.host, address.path, address.account) == ("az", "container", "a/b", "account")


@pytest.mark.parametrize("text", ["s3://", "s3:///x", "s3://b/../c", "ftp://h/x", "file://host/x", "omniverse://h/x"])
def test_what_is_no_place_is_told(text):
    with pytest.raises(StoreError, match=r"://|machine"):
        address_of(text)
