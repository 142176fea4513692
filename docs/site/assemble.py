"""Gather the Markdown, pictures and generated pages of the site in one folder, which the site generator reads."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from docs.site import gallery_pages, plots, reference_pages, repository_pages
from docs.site.repository_pages import COPIED, ROOT

DOCS = ROOT / "docs"
# A link to the results of a benchmark, on a line of its own, becomes the plot of these and a line about the machine.
RESULTS = re.compile(r"^\[([^\]]*)\]\(\.\./benchmarks/results/(\w+)\.jsonl\)$", re.MULTILINE)
# Sizes that tests of the pages make smaller; readers, whose shell may be another, see what stands behind `:-`.
SIZE = re.compile(r"\$\{[A-Z]+:-([^}]*)\}")


def assemble(target: Path) -> None:
    """Fill an empty folder with every file that the site is made of."""
    waiting = {"README.md"}
    machines = plots.draw_all(target / "images" / "plots")
    for file in sorted(DOCS.rglob("*")):
        name = file.relative_to(DOCS)
        if file.suffix in COPIED:
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target / name)
        elif file.suffix == ".md":
            text = RESULTS.sub(
                lambda match: f"![{match[1]}](images/plots/{match[2]}.svg)\n\n{machines[match[2]]}",
                file.read_text(encoding="utf-8"),
            )
            text, needed = repository_pages.relinked(text, f"docs/{name.as_posix()}")
            _write(target / name, SIZE.sub(r"\1", text))
            waiting |= needed
    for name, text in {**reference_pages.pages(), **gallery_pages.pages()}.items():
        _write(target / name, text)
    done: set[str] = set()
    while waiting:
        path = waiting.pop()
        done.add(path)
        text, needed = repository_pages.page_text(path)
        _write(target / repository_pages.page_of(path), text)
        waiting |= needed - done


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
