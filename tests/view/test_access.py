"""The server refuses requests without the token, with another Host header, or with the Origin of another page."""

from __future__ import annotations

import http.client
import json
import re
import socket
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest

pytest.importorskip("uvicorn")
pytest.importorskip("starlette")
sync = pytest.importorskip("websockets.sync.client")
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException  # noqa: E402

from usdsdg.errors import StageError, Unsupported  # noqa: E402
from usdsdg.view.channel import MOST_WAITING, Channel  # noqa: E402
from usdsdg.view.server import LONGEST, MOST_PAGES, Server, check_installed  # noqa: E402


class Served:
    """A server, and the channels of the pages that it has opened."""

    def __init__(self) -> None:
        self.channels: list[Channel] = []
        self.server = Server(self.channels.append, lambda: None)
        self.host = f"127.0.0.1:{self.server.port}"
        self.path = urlsplit(self.server.address).path

    def get(self, path: str, **headers: str) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
        connection.request("GET", path, headers={"Host": self.host, **headers})
        return connection.getresponse()

    def socket(self, *, path: str | None = None, origin: str | None = "", host: str | None = None):
        """Open a websocket as a page of `origin`; "" is the page itself, None sends none."""
        return sync.connect(
            f"ws://{host or self.host}{self.path if path is None else path}socket",
            origin=f"http://{self.host}" if origin == "" else origin,
            sock=socket.create_connection(("127.0.0.1", self.server.port)), proxy=None,
        )  # fmt: skip


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    made = Served()
    yield made
    made.server.close()


def refused(connect) -> int:
    """The status with which a websocket is refused."""
    with pytest.raises(InvalidStatus) as caught:
        connect()
    return caught.value.response.status_code


def test_the_page_and_its_files_are_served_at_the_address(served):
    answer = served.get(served.path)
    body = answer.read().decode()
    assert answer.status == 200
    assert answer.getheader("Content-Type").startswith("text/html")
    assert "//" not in body  # it works without a network
    for name, media in (("main.js", "text/javascript"), ("view.css", "text/css")):
        answer = served.get(served.path + name)
        assert (answer.status, answer.getheader("Content-Type").split(";")[0]) == (200, media)


def test_numbers_on_the_page_have_nouns_in_their_own_number(served):
    for name in ("main.js", "panels.js"):
        assert not re.findall(r"\$\{[\w.]+\} [a-z]{3,}s\b", served.get(served.path + name).read().decode())


def test_the_address_is_on_the_loopback_interface_alone(served):
    assert served.server.address.startswith("http://127.0.0.1:")
    own = socket.gethostbyname(socket.gethostname())
    if own.startswith("127."):
        pytest.skip("this machine has no other address")
    with pytest.raises(OSError, match=r"."):
        socket.create_connection((own, served.server.port), timeout=5)


@pytest.mark.parametrize("path", ["/", "/x/", "/index.html", "/socket", "/favicon.ico", "/..%2f/"])
def test_without_the_token_there_is_nothing(served, path):
    answer = served.get(path)
    assert answer.status == 404
    assert served.server.access.token not in answer.read().decode()


def test_a_wrong_token_opens_no_websocket(served):
    assert refused(lambda: served.socket(path="/" + "x" * 32 + "/")) == 403


def test_tokens_are_long_and_never_the_same(served):
    other = Served()
    other.server.close()
    assert other.path != served.path
    assert len(served.server.access.token) >= 32


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "localhost.evil", ""])
def test_another_name_of_the_machine_is_refused(served, host):
    # As after DNS rebinding: the name leads here, and the browser counts the page as its own.
    assert served.get(served.path, Host=host).status == 403
    if host:
        assert refused(lambda: served.socket(host=host, origin=f"http://{host}")) == 403


@pytest.mark.parametrize("name", ["localhost", "127.0.0.1", "[::1]"])
def test_a_tunnel_may_have_another_port(served, name):
    host = f"{name}:9123"
    assert served.get(served.path, Host=host).status == 200
    with served.socket(host=host, origin=f"http://{host}"):
        pass


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1", None])
def test_another_page_opens_no_websocket_even_with_the_token(served, origin):
    assert refused(lambda: served.socket(origin=origin)) == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null"])
def test_another_page_gets_no_file_even_with_the_token(served, origin):
    assert served.get(served.path + "main.js", Origin=origin).status == 403


def test_the_policy_lets_nothing_in_from_elsewhere(served):
    for path in (served.path, served.path + "main.js", served.path + "nothing.js"):
        headers = served.get(path).headers
        policy = dict(part.strip().split(" ", 1) for part in headers["Content-Security-Policy"].split(";"))
        assert policy["default-src"] == "'none'"
        assert policy["script-src"] == policy["style-src"] == "'self'"
        assert policy["frame-ancestors"] == "'none'"
        assert policy["connect-src"] == f"'self' ws://{served.host}"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == "no-store"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "Access-Control-Allow-Origin" not in headers


@pytest.mark.parametrize(
    "name", ["../server.py", "..%2fserver.py", "%2e%2e/server.py", "__init__.py", "main.js.map", "a/b.js"]
)
def test_only_files_of_the_page_are_served(served, name):
    assert served.get(served.path + name).status == 404


def test_other_methods_are_refused(served):
    connection = http.client.HTTPConnection("127.0.0.1", served.server.port, timeout=20)
    connection.request("POST", served.path, body=b"x", headers={"Host": served.host})
    assert connection.getresponse().status == 405


def test_messages_go_both_ways(served):
    before = len(served.channels)
    with served.socket() as page:
        page.send(json.dumps({"do": "play"}))
        channel = wait_for(lambda: served.channels[before:])[0]
        assert wait_for(channel.asked) == ['{"do": "play"}']
        channel.tell(state={"time": 1.5})
        assert json.loads(page.recv(timeout=20)) == {"state": {"time": 1.5}}
        channel.show("view", {"width": 2}, b"picture")
        message = page.recv(timeout=20)
        length = int.from_bytes(message[:4], "big")
        assert json.loads(message[4 : 4 + length]) == {"kind": "view", "width": 2}
        assert message[4 + length :] == b"picture"
    wait_for(lambda: not channel.is_open)


def test_a_page_that_floods_the_viewer_is_closed(served):
    with served.socket() as page:
        with pytest.raises(ConnectionClosed):
            flood(page)
        assert page.close_code == 1013


def test_messages_that_are_too_long_or_no_text_close_the_socket(served):
    for message in ("x" * (LONGEST + 1), b"\x00\x01"):
        with served.socket() as page:
            page.send(message)
            with pytest.raises(ConnectionClosed):
                page.recv(timeout=20)


def test_only_so_many_pages_are_open_at_once(served):
    wait_for(lambda: not any(channel.is_open for channel in served.channels))
    pages = [served.socket() for _ in range(MOST_PAGES)]
    with pytest.raises(WebSocketException):
        served.socket().recv(timeout=20)
    for page in pages:
        page.close()


def test_a_port_that_is_taken_is_named(served):
    with pytest.raises(StageError, match=str(served.server.port)):
        Server(lambda _: None, lambda: None, port=served.server.port)


def test_without_the_extra_one_line_names_it(monkeypatch):
    import importlib.util

    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "uvicorn" else object())
    with pytest.raises(Unsupported, match=r"needs uvicorn.*pip install 'usdsdg\[view\]'"):
        check_installed()


def flood(page) -> None:
    for _ in range(MOST_WAITING + 100):
        page.send("{}")
    page.recv(timeout=20)


def wait_for(condition):
    give_up = time.monotonic() + 20
    while not (value := condition()):
        assert time.monotonic() < give_up
        time.sleep(0.01)
    return value
