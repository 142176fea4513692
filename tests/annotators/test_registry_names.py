"""`rep.AnnotatorRegistry._annotators`, which some scripts look at."""

import pytest

import usdsdg as rep


def test_registered_annotators_are_listed_by_name():
    known = rep.AnnotatorRegistry._annotators
    assert list(known) == rep.annotators.get_registered_annotators()
    assert len(known) == len(list(known))
    assert "rgb" in known
    assert known["rgb"].get_name() == "rgb"


def test_a_name_that_is_not_registered_is_no_key():
    with pytest.raises(KeyError):
        rep.AnnotatorRegistry._annotators["nothing"]
