"""The files that a behavior's variables name: an asset array, and URLs separated by commas."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Sdf

from usdsdg.errors import AssetError, Unsupported
from usdsdg.session.stage_context import assets_root
from usdsdg.stage import assets

_SCHEMES = ("omniverse://", "http://", "https://", "file://")


def asset_files(listed: Iterable[Sdf.AssetPath] | None, csv: str | None) -> list[str]:
    """Return the files of both variables; paths of `csv` without a scheme are relative to the assets root.

    A file that does not exist is returned as it is named: it is reported where it is opened.
    """
    names = [asset.resolvedPath or asset.path for asset in listed or []]
    for name in filter(None, (part.strip() for part in (csv or "").split(","))):
        names.append(name if name.startswith(_SCHEMES) else f"{assets_root()}/{name.removeprefix('/')}")
    return [_resolved(name) for name in names]


def _resolved(name: str) -> str:
    try:
        return assets.resolve(name)
    except (AssetError, Unsupported):
        return name
