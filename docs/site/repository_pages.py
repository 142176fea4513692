"""Files of the repository that pages link to become pages of the site, and README.md its first page.

A link to `../usdsdg/graph/node.py` works in the repository; in the site it leads to a page with the text of that file,
and a link to a folder to a page that lists its files. So no link depends on where the repository is hosted.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOME = "index.md"
FOLDER = "repository"
# Suffixes of files below docs/ that the site has as they are.
COPIED = (".png", ".svg", ".css", ".js")
SHOWN = (".md", *COPIED)
LANGUAGES = {".py": "python", ".pyi": "python", ".yaml": "yaml", ".yml": "yaml", ".json": "json", ".toml": "toml"}
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
FENCE = re.compile(r"^\s*(```|~~~)")


def page_of(path: str) -> str:
    """Return the name of the site's page, or picture, for a file or folder of the repository."""
    if path == "README.md":
        return HOME
    if path.startswith("docs/") and path.endswith(SHOWN):
        return path.removeprefix("docs/")
    if path.startswith("docs/reference/"):  # the examples of a page of the reference, which stand in that page
        return f"{path.removeprefix('docs/').removesuffix('.py')}.md"
    if path.endswith(".md"):
        # The name README.md would make a page the index of its folder.
        return f"{FOLDER}/{path}".replace("README.md", "about.md")
    return f"{FOLDER}/{path}/index.md" if (ROOT / path).is_dir() else f"{FOLDER}/{path}.md"


def relinked(text: str, source: str) -> tuple[str, set[str]]:
    """Return Markdown whose links to files lead to pages, and the files outside of docs/ that need one.

    Args:
        text: Markdown as it stands in the repository.
        source: Its path there, which its links are relative to.
    """
    needed: set[str] = set()
    page = page_of(source)

    def target(match: re.Match[str]) -> str:
        path, hash_, anchor = match[2].partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return match[0]
        full = posixpath.normpath(posixpath.join(posixpath.dirname(source), path))
        if not (ROOT / full).exists():
            return match[0]  # generated, or dead: the link check tells
        if page_of(full).startswith(f"{FOLDER}/"):
            needed.add(full)
        return f"{match[1]}{posixpath.relpath(page_of(full), posixpath.dirname(page) or '.')}{hash_}{anchor}{match[3]}"

    lines, fenced = [], False
    for line in text.splitlines(keepends=True):
        fenced ^= bool(FENCE.match(line))
        lines.append(line if fenced else LINK.sub(target, line))
    return "".join(lines), needed


def page_text(path: str) -> tuple[str, set[str]]:
    """Return the page of a file or folder of the repository, and the files that it links to in turn."""
    file = ROOT / path
    if file.is_dir():
        names = sorted(one.name for one in file.iterdir() if one.suffix in (*LANGUAGES, ".md"))
        return f"# {path}\n\n{', '.join(f'`{name}`' for name in names) or 'Folders only.'}\n", set()
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        return relinked(text, path)
    fence = "`" * 6
    head = "---\nsearch:\n  exclude: true\n---\n\n"
    return f"{head}# {path}\n\n{fence}{LANGUAGES.get(file.suffix, 'text')}\n{text.rstrip()}\n{fence}\n", set()
