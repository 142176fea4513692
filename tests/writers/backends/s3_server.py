"""A server on this machine that speaks as much of S3's protocol as one needs to store, read and list objects."""

from __future__ import annotations

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape


class S3Server:
    """`objects` is what it holds: {bucket: {key: bytes}}; `refuse` makes it answer with a code of S3's."""

    def __init__(self, *buckets: str) -> None:
        self.objects: dict[str, dict[str, bytes]] = {bucket: {} for bucket in buckets}
        self.kinds: dict[str, str] = {}  # key: Content-Type
        self.signed: list[bool] = []  # of each request
        self.refuse: tuple[int, str] | None = None
        self._http = ThreadingHTTPServer(("127.0.0.1", 0), _handler(self))
        self.url = f"http://127.0.0.1:{self._http.server_port}"

    def __enter__(self) -> S3Server:
        threading.Thread(target=self._http.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._http.shutdown()
        self._http.server_close()


def _handler(server: S3Server) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_PUT(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            if (found := self._bucket()) is not None:
                objects, key = found
                objects[key] = body
                server.kinds[key] = self.headers["Content-Type"]
                self._answer(200)

        def do_GET(self) -> None:
            if (found := self._bucket()) is None:
                return
            objects, key = found
            query = parse_qs(urlsplit(self.path).query)
            if "list-type" in query:
                keys = [each for each in sorted(objects) if each.startswith(query.get("prefix", [""])[0])]
                listed = "".join(f"<Contents><Key>{escape(each)}</Key></Contents>" for each in keys)
                self._answer(
                    200, f"<ListBucketResult><KeyCount>{len(keys)}</KeyCount>{listed}</ListBucketResult>".encode()
                )
            elif key in objects:
                self._answer(200, objects[key])
            else:
                self._error(404, "NoSuchKey")

        def _bucket(self) -> tuple[dict[str, bytes], str] | None:
            server.signed.append("AWS4-HMAC-SHA256" in self.headers.get("Authorization", ""))
            bucket, _, key = unquote(urlsplit(self.path).path).lstrip("/").partition("/")
            if server.refuse:
                return self._error(*server.refuse)
            if bucket not in server.objects:
                return self._error(404, "NoSuchBucket")
            return server.objects[bucket], key

        def _error(self, status: int, code: str) -> None:
            self._answer(status, f"<Error><Code>{code}</Code><Message>no</Message></Error>".encode())

        def _answer(self, status: int, body: bytes = b"") -> None:
            self.send_response(status)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None: ...

    return Handler
