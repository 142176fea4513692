"""Build the site: gather its pages, let zensical make HTML of them, and check every link."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import yaml

from docs.site import links
from docs.site.assemble import DOCS, assemble
from docs.site.repository_pages import ROOT

CONFIGURATION = DOCS / "site" / "mkdocs.yml"
QUIET = "No issues found"


def build(folder: Path) -> list[str]:
    """Build the site in `folder`/site, and list the links that lead out of it in `folder`/external_links.txt.

    Returns:
        Faults, one line each: warnings of the generator, dead links, and pages that the navigation leaves out.
    """
    for name in ("pages", "site"):
        shutil.rmtree(folder / name, ignore_errors=True)
    (folder / "pages").mkdir(parents=True)
    assemble(folder / "pages")
    text = CONFIGURATION.read_text(encoding="utf-8").replace("[ROOT]", f"[{ROOT.as_posix()!r}]")
    (folder / "mkdocs.yml").write_text(f"docs_dir: pages\nsite_dir: site\n{text}", encoding="utf-8")
    command = [sys.executable, "-m", "zensical", "build", "--clean", "--strict", "-f", str(folder / "mkdocs.yml")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    faults = _left_out(yaml.safe_load(text)["nav"])
    if done.returncode or QUIET not in done.stdout + done.stderr:
        return [*faults, f"zensical ended with {done.returncode}:\n{done.stdout}{done.stderr}"]
    dead, outside = links.check(folder / "site")
    listed = "".join(f"{address}  ({page})\n" for address, page in sorted(outside.items()))
    (folder / "external_links.txt").write_text(listed, encoding="utf-8")
    return [*faults, *dead]


def _left_out(nav: list) -> list[str]:
    """Return a fault for each page of docs/ that the navigation does not name."""
    named = set(_pages(nav))
    pages = (file.relative_to(DOCS).as_posix() for file in sorted(DOCS.rglob("*.md")))
    return [f"docs/{page} is not in the nav of docs/site/mkdocs.yml" for page in pages if page not in named]


def _pages(entry: list | dict | str) -> list[str]:
    """Return all pages of a navigation in order."""
    if isinstance(entry, str):
        return [entry]
    return [page for each in (entry.values() if isinstance(entry, dict) else entry) for page in _pages(each)]
