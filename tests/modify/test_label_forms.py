"""The forms in which `rep.modify.semantics` and `rep.create` take labels."""

import pytest

import usdsdg as rep
from usdsdg.errors import GraphError, UsdsdgError
from usdsdg.graph import evaluate
from usdsdg.stage.semantics import labels


def labels_of(item):
    return [labels.get_labels(prim) for prim in item.get_output_prims()["prims"]]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (["class:sphere", "material:rubber"], {"class": ["sphere"], "material": ["rubber"]}),
        (("shape", "sphere"), {"shape": ["sphere"]}),
        ("class:a;shape:b", {"class": ["a"], "shape": ["b"]}),
        ([("class", "a"), ("class", "b")], {"class": ["a", "b"]}),
        ({"class": ["a", "b"]}, {"class": ["a", "b"]}),
        ([["class:a"], ["class:b"]], [{"class": ["a"]}, {"class": ["b"]}]),
    ],
)
def test_forms_of_labels(stage, given, expected):
    expected = expected if isinstance(expected, list) else [expected] * 2
    assert labels_of(rep.create.cube(semantics=given, count=2)) == expected
    cones = rep.create.cone(count=2)
    rep.modify.semantics(given, input_prims=cones)
    assert labels_of(cones) == expected


@pytest.mark.parametrize("wrap", [lambda label: [("class", label)], lambda label: {"class": ["a", label]}])
def test_a_distribution_in_place_of_a_label_is_told_to_draw_pairs(stage, wrap):
    given = wrap(rep.distribution.choice(["a", "b"]))
    cube = rep.create.cube()
    remedy = r"draw the pairs as a whole: rep.distribution.choice\(\[\[\('class', 'a'\)\]"
    with pytest.raises(GraphError, match=remedy):
        rep.create.cube(semantics=given)
    with pytest.raises(GraphError, match=remedy), rep.trigger.on_frame():
        rep.modify.semantics(given, input_prims=cube)


def test_labels_of_a_distribution_are_drawn_at_each_execution(stage):
    with rep.create.cube(semantics=[("class", "old"), ("shape", "cube")], count=3) as cubes:
        drawn = rep.distribution.sequence(["class:a", ("class", "b"), {"class": "c"}], stride=3)
        rep.modify.semantics(drawn, mode="replace")
    evaluate.graph().evaluate()
    assert [each["class"] for each in labels_of(cubes)] == [["a"], ["b"], ["c"]]
    assert {each["shape"][0] for each in labels_of(cubes)} == {"cube"}


def test_labels_are_parsed_and_converted(stage):
    material = rep.create.material_omnipbr(semantics=[("material", "rubber")])
    (prim,) = rep.create.cube(semantics="class:a", material=material).get_output_prims()["prims"]
    assert rep.utils.parse_semantics(prim) == [("class", "a"), ("material", "rubber")]
    for given in ([("class", "a"), ("class", "b")], ["class:a", "class:b"], {"class": ["a", "b"]}):
        assert rep.utils.legacy_semantics_arg_to_new(given) == {"class": ["a", "b"]}


def test_visibility_in_a_list_of_one_is_for_all(stage):
    cubes = rep.create.cube(count=3, visible=False)
    rep.modify.visibility([True], input_prims=cubes)
    seen = [prim.GetAttribute("visibility").Get() for prim in cubes.get_output_prims()["prims"]]
    assert seen == ["inherited"] * 3


@pytest.mark.parametrize("given", [[("class", "")], [("", "cube")], {"class": ["cube", " "]}])
def test_an_empty_label_or_type_is_named(stage, given):
    with pytest.raises(UsdsdgError, match="labels and their types are non-empty strings, not"):
        rep.create.cube(semantics=given)
