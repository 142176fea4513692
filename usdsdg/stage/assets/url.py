"""The forms in which scripts name assets: URLs of servers, drives of Windows, paths of a home, plain paths."""

import os
import re
from urllib.parse import unquote

from usdsdg.errors import AssetUnreadable
from usdsdg.operating_system import IS_WINDOWS

# Folders at the top of an assets root; of the URL of an asset server, the part from one of these on is used.
TOP_FOLDERS = ("Isaac", "NVIDIA")

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/+")  # two letters at least: C:/ is a drive
_DRIVE = re.compile(r"[A-Za-z]:[\\/]")
_TOP = re.compile(f"/({'|'.join(TOP_FOLDERS)})(?=/)")


def scheme_of(text: str) -> str:
    """Return the scheme of a URL in lower case; "" for a path, also for one with a drive.

    USD joins the two slashes after a scheme to one, as in `omniverse:/localhost/a.usd`, which is a URL too.
    """
    found = _SCHEME.match(text)
    return found[1].lower() if found else ""


def is_utf8(text: str) -> bool:
    """Whether a path can be given to USD: bytes of the command line that are no UTF-8 are lone surrogates here."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def check_name(path: str | os.PathLike[str]) -> None:
    """Check that the path of an asset can be given to USD; raises AssetUnreadable otherwise."""
    if not is_utf8(text := os.fspath(path)):
        raise AssetUnreadable(f"{text!r} is not UTF-8, as USD needs paths to be. Rename the file.")


def has_drive(text: str) -> bool:
    """Whether a path begins with a drive of Windows, as `C:\\assets\\a.usd` does."""
    return _DRIVE.match(text) is not None


def is_remote(text: str) -> bool:
    """Whether a URL or path names nothing on this machine: a URL of a server, or a drive where there are none."""
    return scheme_of(text) not in ("", "file", "anon") or (has_drive(text) and not IS_WINDOWS)


def normalized(text: str) -> str:
    """Return a URL or path in the form in which prefixes are compared.

    Forward slashes, `://` after a scheme, scheme, host and drive in lower case, the home folder in place of `~`.
    """
    if scheme := scheme_of(text):
        host, slash, path = text[text.index(":") + 1 :].lstrip("/").partition("/")
        return f"{scheme}://{host.lower()}{slash}{path}"
    if has_drive(f"{text}/"):  # also a drive alone, as prefixes name it
        return text[0].lower() + text[1:].replace("\\", "/")
    return os.path.expanduser(text)


def with_slashes(path: str) -> str:
    """Return a path that a program on Windows wrote, as `.\\textures\\a.png`, in the form that all systems read."""
    return path.replace("\\", "/")


def path_of(text: str) -> str:
    """Return the path in a URL, decoded and without its query: `/a b.usd` of `https://host/a%20b.usd?v=1`."""
    _, _, rest = normalized(text).partition("://")
    _, slash, path = rest.partition("/")
    return slash + unquote(re.split(r"[?#]", path, maxsplit=1)[0])


def below_top_folders(path: str) -> list[str]:
    """Return the parts of a path that begin with a top folder: `Isaac/a.usd` of `/Assets/Isaac/a.usd`.

    A server's own folders may be called Isaac too, so there may be several, longest first.
    """
    return [path[top.start() + 1 :] for top in _TOP.finditer(path)]
