"""The assets that a script names in its text, found without running it."""

from __future__ import annotations

import ast
import re
from pathlib import PurePosixPath
from typing import NamedTuple

from usdsdg.cli.script.certainty import certain
from usdsdg.stage.assets import MESHES, TOP_FOLDERS, is_remote

SUFFIXES = (
    ".usd", ".usda", ".usdc", ".usdz", ".mdl", *MESHES,
    ".png", ".jpg", ".jpeg", ".hdr", ".exr", ".bmp", ".tga", ".tif", ".tiff",
)  # fmt: skip

# Calls whose texts are no assets to read.
_NOT_READ = re.compile(
    r"add_argument|save|export|write|output|capture|print|log|warn|error|startswith|endswith|replace|split"
)


class LiteralAsset(NamedTuple):
    """A URL in the text of a script."""

    url: str
    line: int


def literal_assets(program: ast.AST) -> list[LiteralAsset]:
    """Return the URLs of assets that a script is sure to name when it runs to its end, each once, in text order.

    These are strings that end like an asset and begin with the scheme of a server, a drive, or a top folder of an
    assets root, outside of branches, dictionaries and defaults, and not in calls that write.
    """
    found: dict[str, LiteralAsset] = {}
    for node in certain(program, skip=lambda each: _does_not_read(each) or _is_made_up(each)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and _is_asset(node.value):
            found.setdefault(node.value, LiteralAsset(node.value, node.lineno))
    return list(found.values())


def _is_made_up(node: ast.AST) -> bool:
    """Whether a formatted string has more parts than a root and what is below it."""
    return isinstance(node, ast.JoinedStr) and len(node.values) > 2


def _does_not_read(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    return _NOT_READ.search(name.lower()) is not None


def _is_asset(text: str) -> bool:
    if any(character in text for character in "\n*{<") or _suffix(text) not in SUFFIXES:
        return False
    return is_remote(text) or text.startswith(tuple(f"/{top}/" for top in TOP_FOLDERS))


def _suffix(text: str) -> str:
    return PurePosixPath(text.partition("?")[0]).suffix.lower()
