"""The assets root: a folder laid out like Isaac Sim's, or an http(s) URL of one, which is mirrored to a folder."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Protocol

from usdsdg import errors
from usdsdg.stage.assets import url

ROOT_VARIABLE = "USDSDG_ASSETS_ROOT"

HOW_TO_SET = (
    f"Set the root with {ROOT_VARIABLE}, with --assets-root on the command line, "
    "or in Python with usdsdg.stage.assets.set_assets_root(folder)."
)


class Mirror(Protocol):
    """A copy of an assets root that is a URL; files come when they are asked for."""

    @property
    def url(self) -> str: ...

    @property
    def folder(self) -> str: ...

    def fetch(self, path: str) -> bool:
        """Bring the file of `folder` at the relative `path`, and all that it refers to; False if the root has none."""
        ...


_root: str | None = None
_fallback: Callable[[], str | os.PathLike[str]] | None = None
_announce: Callable[[], object] | None = None
_make_mirror: Callable[[str], Mirror] | None = None
_mirror: Mirror | None = None
_sites: dict[str, Mirror] = {}


def assets_root(*, announce: bool = True) -> str:
    """Return the folder that holds `Isaac` and `NVIDIA`: the one set, else the environment's, else the stand-ins.

    announce: whether the user is told of stand-ins, as where an asset is looked up.

    Of a root that is a URL it is the folder of the mirror, in which files appear once `locate` has been asked for them.

    Raises:
        AssetNotFound: the folder does not exist, or neither a root nor stand-ins are available.
    """
    if mirror := root_mirror():
        return mirror.folder
    if configured := configured_root():
        folder = os.path.abspath(os.path.expanduser(configured))
        if not os.path.isdir(folder):
            raise errors.AssetNotFound(f"the assets root {folder} is not a folder. {HOW_TO_SET}")
        return folder
    if _fallback is None:
        raise errors.AssetNotFound(f"no assets root is set. {HOW_TO_SET}")
    if announce and _announce is not None:
        _announce()
    return os.fspath(_fallback())


def set_assets_root(path: str | os.PathLike[str] | None) -> None:
    """Set the assets root, a folder or an http(s) URL; None returns to the environment or the built-in stand-ins."""
    global _root
    _root = None if path is None else os.fspath(path)


def set_fallback_root(
    make: Callable[[], str | os.PathLike[str]] | None, announce: Callable[[], object] | None = None
) -> None:
    """Register the function that makes stand-in assets and returns their folder, called if no root is set.

    announce: called before it where the user should know of them.
    """
    global _fallback, _announce
    _fallback, _announce = make, announce


def set_mirror_factory(make: Callable[[str], Mirror] | None) -> None:
    """Register the function that makes the mirror of a root that is a URL."""
    global _make_mirror, _mirror
    _make_mirror, _mirror = make, None
    _sites.clear()


def site_mirror(site: str) -> Mirror | None:
    """Return the mirror of a server or bucket, as of "https://host" or "s3://bucket"; None if none can be made."""
    if site not in _sites and _make_mirror is not None:
        _sites[site] = _make_mirror(site)
    return _sites.get(site)


def configured_root() -> str | None:
    """Return the root that was set, or the environment's, as it was written; None if there is neither."""
    return _root or os.environ.get(ROOT_VARIABLE)


def root_mirror() -> Mirror | None:
    """Return the mirror of the root, or None where the root is a folder.

    Raises:
        AssetError: the root is a URL of a kind that cannot be mirrored.
    """
    global _mirror
    configured = configured_root()
    if configured is None or not url.scheme_of(configured) or url.scheme_of(configured) == "file":
        return None
    if _make_mirror is None:
        raise errors.AssetError(f"the assets root {configured} is a URL, and no mirror is available")
    if _mirror is None or _mirror.url != configured.rstrip("/"):
        _mirror = _make_mirror(configured)
    return _mirror
