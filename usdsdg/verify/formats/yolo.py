"""Reader of YoloWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

import yaml

from usdsdg.verify.folder import Folder
from usdsdg.verify.formats.matching import truth_of
from usdsdg.verify.seen import Color, Seen

NAME = "YoloWriter"
_IMAGES, _LABELS, _DESCRIPTION = "images", "labels", "data.yaml"


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the files of each image say."""
    if not folder.has(_DESCRIPTION):
        return
    text = folder.text(_DESCRIPTION, "all")
    described = None if text is None else folder.parsed(_DESCRIPTION, "all", lambda t=text: yaml.safe_load(t) or {})
    names = dict((described or {}).get("names") or {})
    found: dict[tuple[str, str], dict[str, str]] = {}
    for file in files:
        path = PurePosixPath(file)
        if len(path.parts) == 3 and path.parts[0] in (_IMAGES, _LABELS):
            found.setdefault((path.stem, path.parts[1]), {})[path.parts[0]] = file
    for (stem, split), parts in sorted(found.items()):
        view, _, number = stem.rpartition("_")
        mine = list(parts.values())
        seen = Seen(NAME, f"{split}/{number}", view, mine, truth_of(folder, mine, view))
        seen.extra["names"] = {int(key): str(name) for key, name in names.items()}
        if _IMAGES in parts and (image := folder.image(parts[_IMAGES], seen.name)) is not None:
            seen.colors.append(Color(parts[_IMAGES], image, exact=parts[_IMAGES].endswith(".png")))
        if _LABELS in parts and (text := folder.text(parts[_LABELS], seen.name)) is not None:
            seen.lines.append((parts[_LABELS], [line.split(" ") for line in text.splitlines()]))
        else:
            seen.extra["unlabeled"] = mine[0]
        yield seen
