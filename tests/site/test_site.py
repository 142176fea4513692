"""The documentation site is built without a warning, and all of its links lead somewhere."""

import pytest

from docs.site import links, repository_pages
from docs.site.build import build
from tests.browser import browser, missing

pytest.importorskip("zensical")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs")
    return folder, build(folder)


def test_the_site_has_no_faults(site):
    folder, faults = site
    assert faults == []
    assert (folder / "external_links.txt").read_text().startswith("http")


def test_search_finds_pages_but_not_sources(site):
    text = (site[0] / "site" / "search.json").read_text()
    assert "jobs.html" in text
    assert "node.py.html" not in text


def test_readers_see_sizes_in_place_of_variables(site):
    pages = list((site[0] / "pages").rglob("*.md"))
    assert "--set num_frames=40 --set" in (site[0] / "pages/tutorials/meshes_to_detector.md").read_text()
    assert not [page for page in pages if ":-" in page.read_text() and "tutorials" in page.parts]


def test_dead_links_missing_anchors_and_other_servers_are_faults(tmp_path):
    (tmp_path / "a.html").write_text('<a href="b.html#there"></a><a href="b.html#no"></a><a href="c.html"></a>')
    (tmp_path / "b.html").write_text('<p id="there"><script src="https://cdn.example/x.js"></script>')
    faults, outside = links.check(tmp_path)
    assert [fault.split(" ", 1)[1].replace("//", "") for fault in faults] == [
        "b.html#no has no such anchor",
        "c.html leads nowhere",
        "loads https:cdn.example/x.js from another server",
    ]
    assert outside == {}


def test_links_to_files_of_the_repository_lead_to_their_pages():
    text, needed = repository_pages.relinked(
        "[a](../usdsdg/rng.py#x) [b](../jobs.md)\n```\n[c](../usdsdg)\n```\n", "docs/d.md"
    )
    assert text.startswith("[a](repository/usdsdg/rng.py.md#x) ")
    assert "[c](../usdsdg)" in text
    assert needed == {"usdsdg/rng.py"}


@pytest.mark.skipif(missing() is not None, reason=str(missing()))
def test_pages_that_are_opened_as_files_have_no_errors_and_find_words(site):
    with browser() as page:
        page.open(site[0] / "site" / "index.html")
        page.click(".md-search__button")
        # The field and the results are in a shadow root of the element with the focus.
        page.until("return !!(document.activeElement && document.activeElement.shadowRoot)")
        for letter in "bop":
            page.press(letter)
        page.until("return /[1-9][0-9]* results/.test(document.activeElement.shadowRoot.textContent)")
        assert page.errors() == []
