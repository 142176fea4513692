"""Numbers with their nouns in messages."""

import pytest

from usdsdg.errors import counted


@pytest.mark.parametrize(
    ("count", "nouns", "text"),
    [
        (0, ("frame",), "0 frames"),
        (1, ("frame",), "1 frame"),
        (2, ("frame",), "2 frames"),
        (1, ("body still moves", "bodies still move"), "1 body still moves"),
        (2, ("body still moves", "bodies still move"), "2 bodies still move"),
    ],
)
def test_one_thing_has_no_plural(count, nouns, text):
    assert counted(count, *nouns) == text
