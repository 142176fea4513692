"""HTML for the output of notebooks: text is escaped, pictures are data URIs, colors fit light and dark pages."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from usdsdg.pictures.picture import Picture

# Rows of a table, and characters of a value, that are shown.
ROWS, CHARACTERS = 20, 400
_CELL = "text-align:left;padding:1px 10px 1px 0;vertical-align:top"
_FAINT = "opacity:.65"


def text(value: Any) -> str:
    """Escape a value as one line of at most `CHARACTERS` characters."""
    line = " ".join(str(value).split())
    return html.escape(line if len(line) <= CHARACTERS else f"{line[: CHARACTERS - 1]}…")


def title(what: str, about: str = "") -> str:
    """A line with the name of a thing, and what it is."""
    return f'<div><b>{text(what)}</b> <span style="{_FAINT}">{text(about)}</span></div>'


def note(line: str) -> str:
    """A line of explanation."""
    return f'<div style="{_FAINT}">{text(line)}</div>' if line else ""


def image(pixels: np.ndarray, *, width: int | None = None) -> str:
    """A picture, uint8 (H, W, 3), at its own width or another [pixels of the page]."""
    data = base64.b64encode(Picture(pixels)._repr_png_()).decode()
    size = width or pixels.shape[1]
    return f'<img alt="" style="max-width:100%" width="{size}" src="data:image/png;base64,{data}">'


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table of its first `ROWS` rows; more are counted."""
    listed = list(rows)
    head = "".join(f'<th style="{_CELL}">{text(each)}</th>' for each in heads)
    body = "".join(
        "<tr>" + "".join(f'<td style="{_CELL}">{text(each)}</td>' for each in row) + "</tr>" for row in listed[:ROWS]
    )
    more = note(f"and {len(listed) - ROWS} more") if len(listed) > ROWS else ""
    return f'<table style="border-collapse:collapse"><tr>{head}</tr>{body}</table>{more}'


def row(parts: Iterable[str]) -> str:
    """Parts beside each other, as many as the page is wide."""
    inside = "".join(f"<div>{each}</div>" for each in parts)
    return f'<div style="display:flex;flex-wrap:wrap;gap:10px;align-items:flex-start">{inside}</div>'


def details(summary: str, inside: str, *, is_open: bool = False) -> str:
    """A part that folds. summary and inside are HTML."""
    return f"<details{' open' if is_open else ''}><summary>{summary}</summary>{inside}</details>"


def indented(inside: str) -> str:
    """A part that is moved to the right."""
    return f'<div style="margin-left:1.3em">{inside}</div>'
