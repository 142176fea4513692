"""The first five minutes and the tutorials, done as they say, at small sizes."""

import pytest

from tests.sampled_cases import sampled
from tests.site.walk import ROOT, walk

PAGES = [ROOT / "docs/five_minutes.md", *sorted((ROOT / "docs/tutorials").glob("*.md"))]


@pytest.mark.parametrize("page", sampled(PAGES, 4), ids=lambda page: page.stem)
def test_the_page_does_what_it_says(page, tmp_path):
    walk(page, tmp_path)
