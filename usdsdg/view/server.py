"""The server of the page: its files and its websocket, on the loopback interface, in a thread of its own.

It knows nothing of stages: a `Channel` passes messages to the thread that owns the engines.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import socket
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING

from usdsdg.errors import StageError, Unsupported
from usdsdg.view.access import LOOPBACK, Access, Refused, page_headers
from usdsdg.view.channel import Channel, TooMany

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection, Request
    from starlette.responses import Response
    from starlette.websockets import WebSocket

MEDIA = {"html": "text/html", "css": "text/css", "js": "text/javascript"}
# Longest message of a page [bytes].
LONGEST = 1 << 16
# Pages at one time: each has pictures drawn for it.
MOST_PAGES = 8
_START_SECONDS, _IDLE_SECONDS = 120.0, 0.5
# Codes of websockets: refused, and overloaded.
REFUSED, OVERLOADED = 1008, 1013


def check_installed() -> None:
    """Check that the packages of the extra are there.

    Raises:
        Unsupported: one is not.
    """
    for package in ("starlette", "uvicorn", "websockets"):
        if importlib.util.find_spec(package) is None:
            raise Unsupported(f"usdsdg view needs {package}, which is not installed: pip install 'usdsdg[view]'")


@dataclass(frozen=True)
class Answer:
    """A file of the page; `inline_script` is the one that it has inside of it."""

    body: bytes
    media: str
    inline_script: str = ""


class Server:
    """Serves the page until `close`.

    Args:
        opened: called with the channel of each page that is opened, in the server's thread; None: pages have no
            websocket.
        wake: called when a channel has something for the owner.
        port: 0 takes a free one.
        answers: returns further files by their path below the token, None where there is none.

    Raises:
        Unsupported: the extra is not installed.
        StageError: the port is taken.
    """

    def __init__(
        self,
        opened: Callable[[Channel], None] | None = None,
        wake: Callable[[], None] = lambda: None,
        *,
        port: int = 0,
        answers: Callable[[str], Answer | None] = lambda _: None,
    ) -> None:
        check_installed()
        self.access = Access()
        self._opened, self._wake, self._answers = opened, wake, answers
        self._channels: set[Channel] = set()
        self._socket = _bound(port)
        self.port: int = self._socket.getsockname()[1]
        self._thread = threading.Thread(target=self._run, name="usdsdg-view-server", daemon=True)
        self._ready = threading.Event()
        self._thread.start()
        if not self._ready.wait(_START_SECONDS):
            raise StageError("the server of the page did not start")

    @property
    def address(self) -> str:
        """The URL of the page, with its token."""
        return self.access.address(self.port)

    def wait(self) -> None:
        """Return when the server has ended, or raise what interrupts the program."""
        while self._thread.is_alive():
            self._thread.join(_IDLE_SECONDS)  # without a limit Ctrl-C would not interrupt it everywhere

    def close(self) -> None:
        """Stop serving; open pages are told that the viewer has ended."""
        self._server.should_exit = True
        self._thread.join(_START_SECONDS)

    def _run(self) -> None:
        import uvicorn
        from starlette.applications import Starlette
        from starlette.routing import Route, WebSocketRoute

        @asynccontextmanager
        async def lifespan(_: Starlette) -> AsyncIterator[None]:
            self._ready.set()
            yield

        routes = [
            WebSocketRoute("/{token}/socket", self._talk),
            Route("/{token}/{name:path}", self._file, methods=["GET"]),
            Route("/{token}", self._file, methods=["GET"]),
        ]
        config = uvicorn.Config(
            Starlette(routes=routes, lifespan=lifespan), log_level="critical", access_log=False, server_header=False,
            date_header=False, ws_max_size=LONGEST, ws_per_message_deflate=False, timeout_graceful_shutdown=1,
            proxy_headers=False,
        )  # fmt: skip
        self._server = uvicorn.Server(config)
        asyncio.run(self._server.serve(sockets=[self._socket]))

    def _check(self, request: HTTPConnection, *, is_socket: bool = False) -> None:
        # Repeated headers cannot hide one another.
        for name in ("host", "origin"):
            if len(request.headers.getlist(name)) > 1:
                raise Refused(400, f"more than one {name}")
        self.access.check(request.path_params.get("token", ""), dict(request.headers), is_socket=is_socket)

    async def _file(self, request: Request) -> Response:
        from starlette.concurrency import run_in_threadpool
        from starlette.responses import PlainTextResponse, Response

        headers = page_headers(request.headers.get("host", ""))
        try:
            self._check(request)
        except Refused as refused:
            return PlainTextResponse(refused.why, refused.status)
        if "name" not in request.path_params:  # relative addresses of the page need the slash
            return Response(status_code=307, headers={"Location": f"/{self.access.token}/", **headers})
        name = request.path_params["name"]
        found = await run_in_threadpool(self._answers, name) or page_file(name or "index.html")
        if found is None:
            return PlainTextResponse("no such file", 404, headers=headers)
        headers = page_headers(request.headers.get("host", ""), found.inline_script)
        return Response(found.body, media_type=found.media, headers=headers)

    async def _talk(self, socket: WebSocket) -> None:
        try:
            self._check(socket, is_socket=True)
        except Refused as refused:
            await socket.close(REFUSED, refused.why)
            return
        if self._opened is None:
            await socket.close(REFUSED, "this page has no websocket")
            return
        if len(self._channels) >= MOST_PAGES:
            await socket.close(OVERLOADED, f"{MOST_PAGES} pages are open already")
            return
        await socket.accept()
        channel = Channel(self._wake)
        self._channels.add(channel)
        self._opened(channel)
        sender = asyncio.create_task(_send(socket, channel))
        try:
            await _receive(socket, channel)
        finally:
            self._channels.discard(channel)
            channel.close()
            sender.cancel()


async def _receive(socket: WebSocket, channel: Channel) -> None:
    from starlette.websockets import WebSocketDisconnect

    with contextlib.suppress(WebSocketDisconnect, KeyError):  # KeyError: a message that is no text
        while True:
            try:
                channel.ask(await socket.receive_text())
            except TooMany:
                await socket.close(OVERLOADED, "too many messages")
                return
    with contextlib.suppress(RuntimeError):  # it is closed already
        await socket.close(REFUSED)


async def _send(socket: WebSocket, channel: Channel) -> None:
    loop, changed = asyncio.get_running_loop(), asyncio.Event()

    def notify() -> None:
        loop.call_soon_threadsafe(changed.set)

    channel.listen(notify)
    while True:
        await changed.wait()
        changed.clear()
        for message in channel.outgoing():
            # Waits while the page's socket is full, so that pictures that follow replace one another meanwhile.
            await (socket.send_text(message) if isinstance(message, str) else socket.send_bytes(message))


def page_file(name: str) -> Answer | None:
    """Return a file of the page; None if there is none of that name."""
    stem, _, suffix = name.rpartition(".")
    if not stem.replace("_", "").isalnum() or suffix not in MEDIA:
        return None
    file = resources.files("usdsdg.view") / "page" / name
    return Answer(file.read_bytes(), MEDIA[suffix]) if file.is_file() else None


def _bound(port: int) -> socket.socket:
    bound = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((LOOPBACK, port))
        bound.listen()  # at once, so that who reads the address can connect before the server is ready
    except OSError as error:
        bound.close()
        raise StageError(
            f"--port {port} cannot be served on {LOOPBACK}: {error}; leave it out for a free one"
        ) from None
    return bound
