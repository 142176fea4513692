"""Servers on this machine: moto, which speaks S3's protocol, and one that is in front of it and fails as it is told."""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
import socket
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import pytest

from usdsdg.mirror import download
from usdsdg.stores import clients, retries

KEYS = {"AWS_ACCESS_KEY_ID": "testkey", "AWS_SECRET_ACCESS_KEY": "testsecret"}
OF_THE_USER = ("AWS_", "AZURE_", "GOOGLE_", "STORAGE_", "USDSDG_STORE")
_buckets = itertools.count()


def only_ours(monkeypatch: pytest.MonkeyPatch, nowhere: str) -> None:
    """Set credentials of the tests, and nothing of the user; nobody asks a cloud for roles, or pauses for long."""
    monkeypatch.setattr(clients, "PAUSE_SECONDS", (0.01, 0.05))
    monkeypatch.setattr(retries, "QUIET_SECONDS", 0.2)
    monkeypatch.setattr(download, "QUIET_SECONDS", 0.2)
    for name in [each for each in os.environ if each.startswith(OF_THE_USER)]:
        monkeypatch.delenv(name)
    for name in ("AWS_CONFIG_FILE", "AWS_SHARED_CREDENTIALS_FILE"):
        monkeypatch.setenv(name, nowhere)
    for name, value in {**KEYS, "AWS_REGION": "us-east-1", "AWS_METADATA_ENDPOINT": "http://127.0.0.1:1"}.items():
        monkeypatch.setenv(name, value)


@functools.cache
def moto_port() -> int:
    """Return the port of a moto server that runs until this process ends."""
    from moto.s3.responses import S3Response
    from moto.server import ThreadedMotoServer

    # moto checks the condition of a put and then stores, as two steps of one thread among others; in S3 it is one step.
    S3Response.put_object = _one_at_a_time(S3Response.put_object)
    server = ThreadedMotoServer("127.0.0.1", 0, verbose=False)
    server.start()
    return server.get_host_and_port()[1]


def _one_at_a_time(call: Callable[..., Any]) -> Callable[..., Any]:
    lock = threading.Lock()

    def locked(*args: Any, **options: Any) -> Any:
        with lock:
            return call(*args, **options)

    return locked


@functools.cache
def _client(url: str) -> Any:
    """Return a client of another library than the product's."""
    import boto3

    keys = {"aws_access_key_id": KEYS["AWS_ACCESS_KEY_ID"], "aws_secret_access_key": KEYS["AWS_SECRET_ACCESS_KEY"]}
    return boto3.client("s3", endpoint_url=url, region_name="us-east-1", **keys)


class Bucket:
    """A new bucket on a server, which is moto unless `port` says another one."""

    def __init__(self, port: int | None = None) -> None:
        self.port = moto_port() if port is None else port
        self.url = f"http://127.0.0.1:{self.port}"
        self.name = f"bucket-{os.getpid()}-{next(_buckets)}"
        self.client = _client(self.url)
        self.client.create_bucket(Bucket=self.name)

    @property
    def objects(self) -> dict[str, bytes]:
        """What is in it, as another library reads it."""
        pages = self.client.get_paginator("list_objects_v2").paginate(Bucket=self.name)
        keys = [each["Key"] for page in pages for each in page.get("Contents", ())]
        return {key: self.client.get_object(Bucket=self.name, Key=key)["Body"].read() for key in keys}

    def fill(self, keys: Iterable[str]) -> None:
        """Put empty objects, without a request for each."""
        from moto.s3.models import s3_backends

        for key in keys:
            s3_backends["123456789012"]["aws"].put_object(self.name, key, b"")

    def kind(self, key: str) -> str:
        """The media type of an object."""
        return self.client.head_object(Bucket=self.name, Key=key)["ContentType"]

    def uploads(self) -> int:
        """How many multi-part uploads are open."""
        return len(self.client.list_multipart_uploads(Bucket=self.name).get("Uploads", ()))


Fate = Callable[[int, str, str], str]


class FailingProxy:
    """Stands before a server; `fate(number, method, target)` says what becomes of each request.

    "pass": it is answered. "drop": the connection ends before the request is sent on. "lose": it is sent on, and the
    answer is lost. "cut": half of the answer comes. "stall": nothing comes. "503 SlowDown": this is the answer.
    """

    def __init__(self, port: int, fate: Fate | None = None) -> None:
        self.fate: Fate = fate or (lambda number, method, target: "pass")
        self.seen: list[tuple[str, str, str]] = []  # method, target, fate
        self._to, self._numbers, self._ended = port, itertools.count(), threading.Event()
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._socket.getsockname()[1]}"

    def __enter__(self) -> FailingProxy:
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _accept(self) -> None:
        while not self._ended.is_set():
            try:
                client, _ = self._socket.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        with client, contextlib.suppress(ConnectionError):
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            request = _request(client)
            if request is None:
                return
            method, target = request[:2]
            fate = self.fate(next(self._numbers), method, target)
            self.seen.append((method, target, fate))
            if fate == "stall":
                self._ended.wait(60)
            elif fate[0].isdigit():
                status, _, code = fate.partition(" ")
                body = f"<Error><Code>{code}</Code><Message>no</Message></Error>".encode()
                head = f"HTTP/1.1 {status} No\r\nContent-Length: {len(body)}\r\nConnection: close\r\n\r\n"
                client.sendall(head.encode() + body)
            elif fate != "drop":
                answer = b"".join(self._answer(request[2]))
                if fate == "pass":
                    client.sendall(answer)
                elif fate == "cut":
                    client.sendall(answer[: len(answer) // 2])

    def _answer(self, request: bytes) -> Iterator[bytes]:
        with socket.create_connection(("127.0.0.1", self._to)) as server:
            server.sendall(request)
            while data := server.recv(1 << 16):
                yield data


def _request(client: socket.socket) -> tuple[str, str, bytes] | None:
    """Read a request with its body; return its method, its target, and what is sent on: one for each connection."""
    data = b""
    while b"\r\n\r\n" not in data:
        if not (more := client.recv(1 << 16)):
            return None
        data += more
    head, _, body = data.partition(b"\r\n\r\n")
    first, *lines = head.decode("latin-1").split("\r\n")
    headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    parts, size = [body], int(headers.get("content-length", 0)) - len(body)
    while size > 0:
        if not (more := client.recv(min(size, 1 << 16))):
            return None
        parts.append(more)
        size -= len(more)
    kept = [line for line in lines if not line.lower().startswith("connection:")]
    head = "\r\n".join([first, *kept, "Connection: close"]).encode("latin-1")
    method, target, _ = first.split(" ")
    return method, target, head + b"\r\n\r\n" + b"".join(parts)
