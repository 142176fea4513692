import pytest

from usdsdg.errors import ConfigError
from usdsdg.stage.semantics.label_filter import LabelFilter

LABELS = {"class": ["mug", "red_mug", "cup"], "color": ["red"], "shape": ["round"]}


@pytest.mark.parametrize(
    ("predicate", "selected"),
    [
        ("*:*", LABELS),
        ("class:*", {"class": ["mug", "red_mug", "cup"]}),
        ("class : mug", {"class": ["mug"]}),
        ("class:plate", {}),
        ("class: mug | cup", {"class": ["mug", "cup"]}),
        ("class: mug & cup", {"class": ["mug", "cup"]}),
        ("class: mug & plate", {}),
        ("class: mug & !cup", {}),
        ("class: mug & !plate", {"class": ["mug"]}),
        ("class: !plate", {"class": ["mug", "red_mug", "cup"]}),
        ("class: !mug", {}),
        # & binds tighter than |
        ("class: mug & !cup | red_mug", {"class": ["red_mug"]}),
        ("class: plate & mug | cup", {"class": ["cup"]}),
        ("class: *mug", {"class": ["mug", "red_mug"]}),
        ("class: r*g", {"class": ["red_mug"]}),
        ("class: !red*", {}),
        ("* : red", {"color": ["red"]}),
        ("c*: *", {"class": ["mug", "red_mug", "cup"], "color": ["red"]}),
        ("class: mug ; color: *", {"class": ["mug"], "color": ["red"]}),
        ("class: mug , color: *", {"class": ["mug"], "color": ["red"]}),
        ("class: cup; class: mug", {"class": ["mug", "cup"]}),
        ("class: mug;", {"class": ["mug"]}),
    ],
)
def test_selection(predicate, selected):
    assert LabelFilter(predicate).select(LABELS) == selected


def test_the_documented_example():
    predicate = LabelFilter("typeA : labelA & !labelB | labelC , typeB: labelA ; typeC: labelD")
    assert predicate.select({"typeA": ["labelA"]}) == {"typeA": ["labelA"]}
    assert predicate.select({"typeA": ["labelA", "labelB"]}) == {}
    assert predicate.select({"typeA": ["labelB", "labelC"]}) == {"typeA": ["labelC"]}
    assert predicate.select({"typeB": ["labelA"], "typeC": ["labelA"]}) == {"typeB": ["labelA"]}
    assert predicate.select({"typeC": ["labelD"], "typeD": ["labelD"]}) == {"typeC": ["labelD"]}


def test_no_filter_keeps_everything():
    assert LabelFilter().select(LABELS) == LABELS


def test_pattern_characters_other_than_the_star_are_plain():
    assert LabelFilter("class: a.c").select({"class": ["abc", "a.c"]}) == {"class": ["a.c"]}
    assert LabelFilter("class: [ab]").select({"class": ["a", "[ab]"]}) == {"class": ["[ab]"]}


@pytest.mark.parametrize(
    "predicate",
    ["", " ; ", "mug", ": mug", "class:", "class: mug &", "class: | mug", "class: !!mug", "class: (a|b)", "a:b:c"],
)
def test_bad_predicates_say_what_is_wrong(predicate):
    with pytest.raises(ConfigError, match="semantic filter"):
        LabelFilter(predicate)
