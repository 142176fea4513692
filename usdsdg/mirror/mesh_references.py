"""What mesh files refer to: buffers and pictures of glTF, materials of OBJ and their pictures."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

_LIBRARY = re.compile(r"^\s*mtllib\s+(.+?)\s*$", re.MULTILINE)
# Options such as `-s 1 1 1` stand before the name of a picture, which may have spaces.
_OPTION = r"-\w+\s+(?:(?:[-+.\d]\S*|on|off)\s+)*"
_PICTURE = re.compile(rf"^\s*(?:map_\w+|bump|disp|decal|refl|norm)\s+(?:{_OPTION})*(.+?)\s*$", re.MULTILINE)
SUFFIXES = (".gltf", ".obj", ".mtl")


def of_mesh(file: Path, suffix: str) -> Iterator[str]:
    """Yield the relative paths that a file of one of `SUFFIXES` names; nothing of one that is damaged."""
    text = file.read_text(encoding="utf-8", errors="replace")
    if suffix == ".obj":
        yield from _LIBRARY.findall(text)
    elif suffix == ".mtl":
        yield from _PICTURE.findall(text)
    else:
        yield from _of_gltf(text)


def _of_gltf(text: str) -> Iterator[str]:
    try:
        document = json.loads(text)
        named = [each.get("uri", "") for kind in ("buffers", "images") for each in document.get(kind, ())]
    except (ValueError, AttributeError, RecursionError):
        return  # as the reader of the mesh will say
    yield from (unquote(uri) for uri in named if isinstance(uri, str) and uri and not uri.startswith("data:"))
