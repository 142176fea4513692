"""An HTTP server on the loopback that gives files, and misbehaves where a test tells it to."""

from __future__ import annotations

import hashlib
import threading
from collections import Counter
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import unquote


class Server:
    """Files by path below `url`. A `trouble` is called with the handler and the bytes, and answers in its place."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.trouble: dict[str, Callable[[Handler, bytes], None]] = {}
        self.asked: Counter[str] = Counter()
        self.ranges: list[tuple[str, str]] = []  # (path, Range header)
        self.sent: Counter[str] = Counter()  # bytes by path
        self.gives_etags = True
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), type("Bound", (Handler,), {"owner": self}))
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        self.url = f"http://127.0.0.1:{self._server.server_port}/Assets/Isaac/4.2"

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


class Handler(BaseHTTPRequestHandler):
    owner: Server
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: object) -> None: ...

    def do_GET(self) -> None:
        path = unquote(self.path).removeprefix("/Assets/Isaac/4.2/")
        self.owner.asked[path] += 1
        if path not in self.owner.files:
            self.send_error(404)
            return
        data = self.owner.files[path]
        if path in self.owner.trouble:
            self.owner.trouble[path](self, data)
        else:
            self.give(data)

    def give(self, data: bytes, *, upto: int | None = None, ranges: bool = True) -> None:
        """Answer with the bytes that were asked for, and end the connection after `upto` of them."""
        path = unquote(self.path).removeprefix("/Assets/Isaac/4.2/")
        asked = self.headers.get("Range", "") if ranges else ""
        etag = f'"{hashlib.md5(data).hexdigest()}"'
        first = int(asked.removeprefix("bytes=").split("-")[0]) if asked else 0
        if self.headers.get("Range"):
            self.owner.ranges.append((path, self.headers["Range"]))
        if self.headers.get("If-Match", etag) != etag:
            self.send_error(412)
            return
        self.send_response(206 if asked else 200)
        if asked:
            self.send_header("Content-Range", f"bytes {first}-{len(data) - 1}/{len(data)}")
        if self.owner.gives_etags:
            self.send_header("ETag", etag)
        self.send_header("Content-Length", str(len(data) - first))
        self.end_headers()
        part = data[first:] if upto is None else data[first : first + upto]
        self.wfile.write(part)
        self.owner.sent[path] += len(part)
        if upto is not None:
            self.close_connection = True


def cut_off(upto: int, times: int) -> Callable[[Handler, bytes], None]:
    """A trouble: end the connection after `upto` bytes, so many times; then behave."""
    left = [times]

    def answer(handler: Handler, data: bytes) -> None:
        left[0] -= 1
        handler.give(data, upto=upto if left[0] >= 0 else None)

    return answer
