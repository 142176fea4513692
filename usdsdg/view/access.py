"""Who may read the page: a random token in its address, the names of this machine, and pages of its own origin."""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field

LOOPBACK = "127.0.0.1"
# Names by which a browser asks for a server of its own machine, also through a tunnel, whose port differs.
_HOSTS = ("127.0.0.1", "localhost", "[::1]")
TOKEN_BYTES = 24


@dataclass(frozen=True)
class Refused(Exception):
    """A request that is not answered: the status, and why, for the log of the one who made it."""

    status: int
    why: str


@dataclass(frozen=True)
class Access:
    """The rules of one server.

    A page elsewhere on the web that asks this server knows no token; one whose name was made to lead to this machine
    (DNS rebinding) has another Host; one that opens a websocket has another Origin.
    """

    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES))

    def address(self, port: int) -> str:
        """Return the URL of the page."""
        return f"http://{LOOPBACK}:{port}/{self.token}/"

    def check(self, token: str, headers: Mapping[str, str], *, is_socket: bool = False) -> None:
        """Check a request by the token of its path and its headers, whose names are in lower case.

        is_socket: whether it opens a websocket. Browsers send the Origin of the page then; without it none is opened.

        Raises:
            Refused: it may not be answered.
        """
        host = headers.get("host", "")
        if _name_of(host) not in _HOSTS:
            raise Refused(403, "the Host is not a name of this machine")
        origin = headers.get("origin")
        if (is_socket or origin is not None) and origin != f"http://{host}":
            raise Refused(403, "the Origin is another page")
        # In constant time, so that the answer's time tells nothing of the token.
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            raise Refused(404, "no such page: the address has a token, which the command prints")


def _name_of(host: str) -> str:
    """Return a Host without its port."""
    name, colon, port = host.rpartition(":")
    return (name if colon and port.isdigit() else host).lower()


def page_headers(host: str, inline_script: str = "") -> dict[str, str]:
    """Return the headers of every answer: only files of this server run, nothing is asked elsewhere, no page frames it.

    host: as the request names it; older browsers do not count a websocket as 'self'. inline_script: the one that a page
    has inside of it, which then may have inline styles too.
    """
    digest = base64.b64encode(hashlib.sha256(inline_script.encode()).digest()).decode()
    policy = {
        "default-src": "'none'",
        "script-src": f"'sha256-{digest}'" if inline_script else "'self'",
        "style-src": "'unsafe-inline'" if inline_script else "'self'",
        "img-src": "'self' data: blob:",
        "connect-src": f"'self' ws://{host}",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'none'",
    }
    return {
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
        "Referrer-Policy": "no-referrer",  # the token is part of the address
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cache-Control": "no-store",
    }
