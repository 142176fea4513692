"""Generation of the HTML page: values as JSON, images as data URIs, style and script inline."""

import html
import json
import os
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.datasets.seen_object import SeenObject
from usdsdg.errors import OutputNotWritable
from usdsdg.inspect import statistics
from usdsdg.inspect.dataset import read_dataset
from usdsdg.inspect.embedding import BUDGET, Embedding, Progress, Shown, embed
from usdsdg.inspect.image_encoding import Encoded
from usdsdg.inspect.layers import KINDS
from usdsdg.inspect.records import Dataset, Problem

# Media type of images whose pixels are ids.
_SHARP = "image/png"
# Number of problems of one kind that are listed; the rest is only counted.
LISTED = 200
# What a page is called, so that an argument in the wrong place replaces nothing else.
PAGES = (".html", ".htm")


def inspect(
    folder: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    name: str | None = None,
    budget: int = BUDGET,
    progress: Progress | None = None,
    report: Callable[[Problem], None] | None = None,
) -> Path:
    """Write one HTML page about the datasets in `folder`; return its path (default `folder`/inspect.html).

    `name` is what the page calls the folder, instead of its path: the URL of which it is a copy.
    `budget` limits the bytes of all images on the page; beyond it images are downscaled or omitted.
    `report` is called with each problem that the page lists.

    Raises:
        DatasetError: the folder is missing, or contains no known dataset.
        OutputNotWritable: the page cannot be written.
    """
    dataset = read_dataset(Path(folder))
    embedding = embed(dataset, budget=budget, progress=progress)
    target = Path(output) if output is not None else Path(folder) / "inspect.html"
    _write(target, page(dataset, embedding, name))
    if report is not None:
        for problem in dataset.problems:
            report(problem)
    return target


def page(dataset: Dataset, embedding: Embedding, name: str | None = None) -> str:
    """Return the page as text; name: of the dataset, in place of the path of its folder."""
    values, images = _values(dataset, embedding, _name(dataset, name))
    return filled_page(values, [image.uri for image in images])


def linked_page(dataset: Dataset, embedding: Embedding, folder: str) -> tuple[str, list[Encoded]]:
    """Return the page as text, and its images, to which it refers as files 0, 1, ... of a folder."""
    values, images = _values(dataset, embedding, _name(dataset))
    return filled_page(values, [f"{folder}/{number}" for number in range(len(images))]), images


def script() -> str:
    """Return what the page has between the tags of its script."""
    return f"\n{_part('charts.js')}{_part('viewer.js')}\n"


def filled_page(values: dict[str, Any], addresses: Sequence[str]) -> str:
    """Return the page of some values, with the addresses of the images that they refer to by index."""
    template, *_ = parts = [_part(name) for name in ("page.html", "page.css", "charts.js", "viewer.js")]
    # A label or path could hold "</script>".
    data = json.dumps(values, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    filled = {
        "{{title}}": html.escape(f"{values['title']} – usdsdg inspect"),
        "{{style}}": parts[1],
        "{{script}}": parts[2] + parts[3],
        "{{data}}": data,
        "{{images}}": "\n".join(
            f'<script type="text/plain" id="i{i}">{address}</script>' for i, address in enumerate(addresses)
        ),
    }
    # At once: what is filled in may hold such a token itself, as the name of a folder.
    return re.sub("|".join(map(re.escape, filled)), lambda token: filled[token[0]], template)


def _text(path: str | os.PathLike[str]) -> str:
    """Decode a path as UTF-8, also if Python kept undecodable bytes of it because of the locale."""
    return os.fsencode(path).decode("utf-8", "replace")


def _part(name: str) -> str:
    return (resources.files("usdsdg.inspect") / "page" / name).read_text(encoding="utf-8")


def _name(dataset: Dataset, name: str | None = None) -> str:
    return _text(dataset.path.resolve()) if name is None else name


def _last(name: str) -> str:
    """Return the last part of a path or URL."""
    return name.replace(os.sep, "/").rstrip("/").rpartition("/")[2]


def _values(dataset: Dataset, embedding: Embedding, name: str) -> tuple[dict[str, Any], list[Encoded]]:
    """Return the page's values, and the images that these refer to by index."""
    classes = statistics.classes(dataset)
    names = [each["name"] for each in classes]
    images: list[Encoded] = []
    views = sorted({frame.view for frame in dataset.frames})
    values = {
        "title": _last(name),
        "folder": name,
        "writers": dataset.writers,
        "metadata": dataset.metadata,
        "views": views,
        "totals": {
            "frames": len(dataset.frames),
            "shown": len(embedding.shown),
            "objects": sum(len(frame.objects) for frame in dataset.frames),
        },
        "notes": [*([embedding.note] if embedding.note else []), *dataset.notes],
        "classes": classes,
        "histograms": statistics.histograms(dataset, names),
        "problems": _problems(dataset),
        "unshown": dict(sorted(dataset.unshown.items())),
        "layers": _layers(embedding),
        "frames": [_frame(shown, views, names, images) for shown in embedding.shown],
    }
    return values, images


def _layers(embedding: Embedding) -> list[str]:
    """Return the kinds of layers in the order of the page."""
    found = dict.fromkeys(kind for shown in embedding.shown for kind in shown.layers)
    return [*(kind for kind in KINDS if kind in found), *sorted(found.keys() - set(KINDS))]


def _problems(dataset: Dataset) -> list[dict[str, Any]]:
    """Return problems by kind: their number, and the first of them with their frames."""
    counts = Counter(problem.kind for problem in dataset.problems)
    return [
        {"kind": kind, "count": count, "list": [[p.text, p.frame] for p in dataset.problems if p.kind == kind][:LISTED]}
        for kind, count in counts.most_common()
    ]


def _frame(shown: Shown, views: list[str], names: list[str], images: list[Encoded]) -> dict[str, Any]:
    def number(image: Encoded) -> int:
        images.append(image)
        return len(images) - 1

    frame = shown.frame
    return {
        "name": frame.name,
        "view": views.index(frame.view),
        "size": shown.size,
        "picture": number(shown.picture) if shown.picture else None,
        "layers": {
            kind: {"image": number(encoded), "values": _rounded(encoded.values), "sharp": encoded.media == _SHARP}
            for kind, encoded in shown.layers.items()
        },
        "labeled": frame.labeled,
        "objects": [_object(seen, names) for seen in frame.objects],
    }


def _object(seen: SeenObject, names: list[str]) -> dict[str, Any]:
    """Return the known values of an object; pixels rounded to a tenth."""
    values = {
        "class": names.index(seen.label),
        "path": seen.prim_path or None,
        "box": _rounded(seen.box),
        "loose": _rounded(seen.loose),
        "cuboid": _rounded(seen.cuboid),
        "edges": _rounded(seen.edges),
        "axes": _rounded(seen.axes),
        "outline": None if seen.outline is None else [_rounded(polygon) for polygon in seen.outline],
        "keypoints": _rounded(seen.keypoints),
        "size": _rounded(seen.size),
        "distance": _rounded(seen.distance),
        "visibility": _rounded(seen.visibility),
        "truncation": _rounded(seen.truncation),
    }
    return {key: value for key, value in values.items() if value is not None}


def _rounded(values: Any) -> Any:
    """Round for JSON: arrays of pixels to a tenth, numbers to a thousandth; None if a value is not finite."""
    if values is None or not np.isfinite(values).all():
        return None
    return np.round(np.asarray(values, float), 3 if np.ndim(values) == 0 else 1).tolist()


def _write(target: Path, text: str) -> None:
    """Write the file atomically."""
    if target.exists() and target.suffix.lower() not in PAGES:
        raise OutputNotWritable(f"{target} exists and is no {PAGES[0]}, so it is not replaced; give another output")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, draft = tempfile.mkstemp(prefix=f".{target.name}-", dir=target.parent)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
            os.chmod(draft, 0o644)
            os.replace(draft, target)
        except BaseException:
            os.unlink(draft)
            raise
    except OSError as error:
        raise OutputNotWritable(
            f"the page cannot be written to {target}: {error.strerror or error}; choose another file with --output"
        ) from error
