"""The page of a dataset: what `usdsdg inspect` draws, with pictures that the browser asks for when it shows them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from usdsdg.inspect.dataset import read_dataset
from usdsdg.inspect.embedding import embed
from usdsdg.inspect.report import linked_page, script
from usdsdg.session.progress import report
from usdsdg.view.server import Answer

_PICTURES = "pictures"


def dataset_page(folder: Path) -> Callable[[str], Answer | None]:
    """Read a dataset, and return what answers for the files of its page.

    Raises:
        DatasetError: the folder is missing, or contains no known dataset.
    """
    dataset = read_dataset(folder)
    text, images = linked_page(dataset, embed(dataset, progress=report), _PICTURES)
    page = Answer(text.encode(), "text/html", script())

    def answer(name: str) -> Answer | None:
        if not name:
            return page
        within, _, number = name.partition("/")
        if within != _PICTURES or not number.isdecimal() or int(number) >= len(images):
            return None
        return Answer(images[int(number)].data, images[int(number)].media)

    return answer
