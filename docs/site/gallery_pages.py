"""Pages of the gallery: each picture with the program that made it."""

from __future__ import annotations

import ast
from pathlib import Path

from docs.site.repository_pages import ROOT

FOLDER = ROOT / "docs" / "gallery"
# In the order of the gallery.
NAMES = ("groceries", "glass", "bin", "labels", "lights", "materials")


def pages() -> dict[str, str]:
    """Return the generated pages by their names in the site."""
    made, figures = {}, []
    for name in NAMES:
        program = FOLDER / f"{name}.py"
        title, text = _page(program)
        made[f"gallery/{name}.md"] = text
        figures.append(
            f'<figure><a href="{name}.html"><img src="{name}.png" alt="{title}"></a>'
            f"<figcaption>{title}</figcaption></figure>"
        )
    made["gallery/index.md"] = (
        "# Gallery\n\nEach picture was made by the program behind it, with assets that are made by code.\n\n"
        f'<div class="gallery">{"".join(figures)}</div>\n'
    )
    return made


def _page(program: Path) -> tuple[str, str]:
    """Return the title and the page of a program."""
    source = program.read_text(encoding="utf-8")
    about = ast.get_docstring(ast.parse(source)) or ""
    title, _, details = about.partition(":")
    code = source.split('"""', 2)[2].lstrip()
    text = f"# {title.strip()}\n\n![{title.strip()}]({program.stem}.png)\n\n{details.strip().capitalize()}\n\n"
    return title.strip(), f'{text}```python title="{program.name}"\n{code}```\n'
