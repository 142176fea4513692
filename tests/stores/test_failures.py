"""Servers that fail: what passes is waited for, what does not is told at once, with what to do."""

import warnings
from functools import partial

import pytest

from tests.stores.servers import Bucket, FailingProxy, only_ours
from usdsdg.errors import OutputNotWritable, StoreError, UsdsdgWarning
from usdsdg.stores import clients, open_store

PASSING = ["503 SlowDown", "429 TooManyRequests", "drop", "cut"]


@pytest.fixture(autouse=True)
def ours(monkeypatch, tmp_path):
    only_ours(monkeypatch, str(tmp_path / "none"))


@pytest.fixture
def bucket():
    return Bucket()


@pytest.fixture
def proxy(bucket):
    with FailingProxy(bucket.port) as running:
        yield running


def opened(bucket, proxy, seconds=20.0):
    return open_store(f"s3://{bucket.name}/p", endpoint_url=proxy.url, retry_seconds=seconds)


def first(count, fate):
    """The first requests have this fate, the others pass."""
    return lambda number, method, target: fate if number < count else "pass"


@pytest.mark.parametrize("fate", PASSING)
def test_every_call_outlives_what_passes(bucket, proxy, fate):
    store = opened(bucket, proxy)
    bucket.client.put_object(Bucket=bucket.name, Key="p/x", Body=b"1")
    for call in (
        partial(store.put, "y", b"2"),
        partial(store.get, "x"),
        partial(store.size, "x"),
        lambda: list(store.list()),
        partial(store.delete, "z"),
        partial(store.put_if_absent, "z", b"3"),
    ):
        before = len(proxy.seen)
        proxy.fate = lambda number, method, target, before=before: fate if number < before + 2 else "pass"
        call()
        assert [each[2] for each in proxy.seen[before : before + 2]] == [fate, fate]
    assert bucket.objects == {"p/x": b"1", "p/y": b"2", "p/z": b"3"}


@pytest.mark.parametrize("fate", ["lose", "cut"])
def test_a_put_with_a_condition_whose_answer_is_lost_was_done(bucket, proxy, fate):
    store = opened(bucket, proxy)
    proxy.fate = first(1, fate)
    assert store.put_if_absent("lock", b"mine") is True
    entry, before = store.get_entry("lock"), len(proxy.seen)
    proxy.fate = lambda number, method, target: fate if number == before else "pass"
    assert store.put_if_match("lock", b"renewed", entry.etag) is True
    assert bucket.objects == {"p/lock": b"renewed"}
    assert store.put_if_match("lock", b"late", entry.etag) is False


def test_a_lost_answer_does_not_make_anothers_file_mine(bucket, proxy):
    store = opened(bucket, proxy)
    bucket.client.put_object(Bucket=bucket.name, Key="p/lock", Body=b"yours")
    proxy.fate = first(2, "lose")
    assert store.put_if_absent("lock", b"mine") is False
    assert bucket.objects == {"p/lock": b"yours"}


def test_amazons_conflict_of_two_writers_is_tried_again(bucket, proxy):
    proxy.fate = first(2, "409 ConditionalRequestConflict")
    assert opened(bucket, proxy).put_if_absent("lock", b"mine") is True


@pytest.mark.parametrize("fate", ["503 SlowDown", "drop", "lose"])
def test_parts_of_large_files_outlive_what_passes(bucket, proxy, fate):
    data = bytes(range(256)) * (20 << 12)  # 20 MB: three parts
    proxy.fate = lambda number, method, target: fate if number in (0, 2, 3, 5) else "pass"
    opened(bucket, proxy).put("large", [memoryview(data)[:1], memoryview(data)[1:]])
    assert bucket.objects == {"p/large": data}


def test_a_lost_answer_to_the_end_of_an_upload_is_outlived(bucket, proxy):
    ends = []

    def fate(number, method, target):
        if method == "POST" and "uploadId" in target:
            ends.append(target)
            return {1: "lose", 2: "404 NoSuchUpload"}.get(len(ends), "pass")
        return "pass"

    proxy.fate = fate
    opened(bucket, proxy).put("large", b"1" * (9 << 20))
    assert bucket.objects == {"p/large": b"1" * (9 << 20)}
    assert len(ends) == 3  # lost, refused since it was done, and of the second upload


def test_a_large_file_is_there_whole_or_not_at_all(bucket, proxy):
    proxy.fate = lambda number, method, target: "drop" if "partNumber=2" in target else "pass"
    with pytest.raises(OutputNotWritable, match="does not answer"):
        opened(bucket, proxy, seconds=0).put("large", bytes(20 << 20))
    assert bucket.objects == {}
    assert bucket.uploads() == 0


def test_lists_go_on_where_they_ended(bucket, proxy):
    for number in range(5):
        bucket.client.put_object(Bucket=bucket.name, Key=f"p/{number}", Body=b"")
    listed = opened(bucket, proxy).list()
    proxy.fate = first(3, "cut")
    assert [path for path, _ in listed] == ["0", "1", "2", "3", "4"]


def test_a_store_that_is_gone_for_long_is_waited_for_aloud(bucket, proxy):
    proxy.fate = first(12, "drop")
    with pytest.warns(UsdsdgWarning, match=r"asked again for up to 60 s, since.*USDSDG_STORE_RETRY_SECONDS"):
        opened(bucket, proxy, seconds=60).put("x", b"1")
    assert bucket.objects == {"p/x": b"1"}


def test_a_store_that_stays_away_ends_in_one_line(bucket, monkeypatch):
    with FailingProxy(bucket.port) as gone:
        pass
    monkeypatch.setenv("USDSDG_STORE_RETRY_SECONDS", "0.3")
    store = open_store(f"s3://{bucket.name}/p", endpoint_url=gone.url)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UsdsdgWarning)
        with pytest.raises(OutputNotWritable, match=r"^s3://.*/p/x cannot be written: the server does not answer"):
            store.put("x", b"1")
        with pytest.raises(StoreError, match=r"listed: the server does not answer.*\(server: http://127"):
            list(store.list())


def test_a_server_that_never_answers_is_left(bucket, proxy, monkeypatch):
    monkeypatch.setattr(clients, "ANSWER_SECONDS", 0.3)
    proxy.fate = lambda number, method, target: "stall"
    with pytest.raises(StoreError, match="does not answer"):
        opened(bucket, proxy, seconds=0).get("x")


@pytest.mark.parametrize(
    ("fate", "remedy"),
    [
        ("403 AccessDenied", r"do not allow it \(AccessDenied\); they need s3:ListBucket"),
        ("403 InvalidAccessKeyId", r"wrong or have expired \(InvalidAccessKeyId\); set AWS_ACCESS_KEY_ID"),
        ("403 SignatureDoesNotMatch", r"wrong or have expired"),
        ("400 ExpiredToken", r"wrong or have expired"),
        ("404 NoSuchBucket", "no such bucket; make it"),
        ("301 PermanentRedirect", r"another region.*AWS_REGION"),
        ("400 EntityTooLarge", "EntityTooLarge"),
    ],
)
def test_what_does_not_pass_is_told_at_once(bucket, proxy, fate, remedy):
    store = opened(bucket, proxy)
    proxy.fate = lambda number, method, target: fate
    for call in (store.put, store.put_if_absent):
        with pytest.raises(OutputNotWritable, match=rf"^s3://[^\n]*written: [^\n]*{remedy}[^\n]*\.$"):
            call("x", b"1")
    for call in (lambda: store.get("x"), lambda: list(store.list()), lambda: store.put_if_match("x", b"", '"1"')):
        with pytest.raises(StoreError, match=remedy):
            call()
    assert len(proxy.seen) == 5


def test_what_a_server_cannot_do_is_told(bucket, proxy):
    proxy.fate = lambda number, method, target: "501 NotImplemented"
    with pytest.raises(OutputNotWritable, match="answers 501 NotImplemented"):
        opened(bucket, proxy).put_if_absent("x", b"1")
    assert len(proxy.seen) == 1


def test_no_credentials_at_all(bucket, monkeypatch):
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    store = open_store(f"s3://{bucket.name}", endpoint_url=bucket.url)
    with pytest.raises(OutputNotWritable, match="no credentials for it; set AWS_ACCESS_KEY_ID and AWS_SEC"):
        store.put("x", b"")


@pytest.mark.parametrize("text", ["soon", "-1", "inf", "nan"])
def test_a_wrong_patience_is_told(text, monkeypatch):
    monkeypatch.setenv("USDSDG_STORE_RETRY_SECONDS", text)
    with pytest.raises(StoreError, match=f"USDSDG_STORE_RETRY_SECONDS is '{text}'; expected a number of seconds"):
        open_store("memory://x")


def test_web_servers_are_only_read():
    store = open_store("https://127.0.0.1:1/x")
    for call in (partial(store.put, "a", b""), partial(store.put_if_absent, "a", b""), partial(store.delete, "a")):
        with pytest.raises(OutputNotWritable, match="web servers are only read"):
            call()


@pytest.mark.parametrize("key", ["a\tb", "a\nb", "a\x7fb"])
def test_control_characters_are_told(key):
    with pytest.raises(StoreError, match="control character"):
        open_store("memory://x").put(key, b"")


def test_azure_would_turn_backslashes(monkeypatch):
    monkeypatch.setenv("AZURE_STORAGE_ACCOUNT_NAME", "nobody")
    with pytest.raises(StoreError, match="which Azure would make a slash"):
        open_store("az://container").put("a\\b", b"")
