"""The links of a built site: those inside must lead somewhere, and nothing may be loaded from another server."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href"}


class Page(HTMLParser):
    """What a page of HTML links to, loads, and can be linked to."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect the addresses and anchors of an element."""
        values = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := values.get(key))}
        if tag == "a" and (address := values.get("href")) is not None:
            self.links.append(address)
        elif (address := values.get(LOADED.get(tag, ""))) and values.get("rel") != "canonical":
            self.loaded.append(address)


def check(site: Path) -> tuple[list[str], dict[str, str]]:
    """Return the faults of a site's links, and the addresses outside of it with a page that has each.

    Args:
        site: Folder of the built site.
    """
    pages = {file: Page(file) for file in sorted(site.rglob("*.html"))}
    faults: list[str] = []
    outside: dict[str, str] = {}
    for file, page in pages.items():
        name = file.relative_to(site).as_posix()
        for address in page.loaded:
            if urlsplit(address).netloc:
                faults.append(f"{name} loads {address} from another server")
            elif not address.startswith("data:"):
                faults += _missing(site, file, address, pages, name)
        for address in page.links:
            if urlsplit(address).scheme or address.startswith("//"):
                outside.setdefault(address, name)
            else:
                faults += _missing(site, file, address, pages, name)
    return sorted(set(faults)), outside


def _missing(site: Path, file: Path, address: str, pages: dict[Path, Page], name: str) -> list[str]:
    """Return the fault of an address inside the site, or nothing."""
    parts = urlsplit(address)
    base = site if parts.path.startswith("/") else file.parent
    target = (base / unquote(parts.path).lstrip("/")).resolve() if parts.path else file
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return [f"{name}: {address} leads nowhere"]
    anchor = unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors and not anchor.startswith("__"):
        return [f"{name}: {address} has no such anchor"]
    return []
