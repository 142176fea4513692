"""Every likely mistake is made, and what is said of it has its remedy and is what docs/mistakes.md shows."""

import pytest

from tests.cli.likely_mistakes import MISTAKES, PAGE, page, said
from usdsdg.session import session


@pytest.fixture(scope="module")
def texts(tmp_path_factory):
    yield {mistake: said(mistake, tmp_path_factory.mktemp("mistake")) for mistake in MISTAKES}
    session.restart()


def test_there_are_forty():
    assert len({(each.kind, each.text) for each in MISTAKES}) >= 40


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda each: each.text.replace("\n", " ")[:60])
def test_what_is_said_has_the_remedy(texts, mistake):
    assert mistake.remedy in texts[mistake]
    assert "Traceback" not in texts[mistake]


def test_the_page_shows_what_is_said(texts):
    shown = PAGE.read_text(encoding="utf-8")
    assert shown == page(texts), "python -m tests.cli.likely_mistakes writes the page anew"
