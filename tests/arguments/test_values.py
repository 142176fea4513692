"""Argument values of `create` and `modify`: one for all prims, one per prim, or an error."""

import re

import numpy as np
import pytest
from pxr import UsdGeom

import usdsdg as rep
from usdsdg.errors import ArgumentError, GraphError
from usdsdg.graph import evaluate
from usdsdg.stage.semantics import labels


def values(stage, item, attribute):
    return [stage.GetPrimAtPath(path).GetAttribute(attribute).Get() for path in item.prims]


ONES, ROWS = (1.0, 1.0, 1.0), [(0.0, 1.0, 2.0), (3.0, 4.0, 5.0)]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (ONES, [ONES, ONES]),
        (1, [ONES, ONES]),
        (np.ones(3), [ONES, ONES]),
        (ROWS, ROWS),
        (np.array(ROWS), ROWS),
    ],
)
def test_a_position_is_for_all_prims_or_one_per_prim(stage, given, expected):
    assert values(stage, rep.create.cube(count=2, position=given), "xformOp:translate") == expected


def test_three_numbers_are_one_color_even_for_three_lights(stage):
    lights = rep.create.light(light_type="sphere", color=[1, 0, 0.5], intensity=[1, 2, 3], count=3)
    children = [f"{path}/SphereLight" for path in lights.prims]
    for path, intensity in zip(children, (1, 2, 3), strict=True):
        prim = stage.GetPrimAtPath(path)
        assert prim.GetAttribute("inputs:color").Get() == (1, 0, 0.5)
        assert prim.GetAttribute("inputs:intensity").Get() == intensity


def test_visibility_and_labels_may_be_given_per_prim(stage):
    cubes = rep.create.cube(
        count=2, visible=[True, False], semantics=[[("class", "a"), ("part", "p")], {"class": ["b", "c"]}]
    )
    prims = [stage.GetPrimAtPath(path) for path in cubes.prims]
    assert [UsdGeom.Imageable(prim).ComputeVisibility() for prim in prims] == ["inherited", "invisible"]
    assert [labels.get_labels(prim) for prim in prims] == [{"class": ["a"], "part": ["p"]}, {"class": ["b", "c"]}]


def test_two_pairs_for_two_prims_are_labels_of_both(stage):
    cubes = rep.create.cube(count=2, semantics=[("class", "a"), ("part", "p")])
    both = [labels.get_labels(stage.GetPrimAtPath(path)) for path in cubes.prims]
    assert both == [{"class": ["a"], "part": ["p"]}] * 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"semantics": "cube"},
            "semantics is 'cube'; expected pairs of a type and a label such as [('class', 'cube')]",
        ),
        ({"semantics": [("class",)], "count": 2}, "semantics is [('class',)]; expected pairs"),
        ({"semantics": {"class": 3}}, "semantics is {'class': 3}; expected pairs"),
        (
            {"position": [(0, 0, 0), (1, 1, 1)], "count": 3},
            "position is [(0, 0, 0), (1, 1, 1)]; expected three numbers",
        ),
        ({"position": "up"}, "position is 'up'; expected three numbers"),
        ({"scale": (1, 2)}, "scale is (1, 2); expected three numbers, one number for all of them, or a list"),
        ({"rotation": (1, 2, 3, 4)}, "rotation is (1, 2, 3, 4)"),
        ({"look_at": (1, 2)}, "look_at is (1, 2)"),
        ({"count": -1}, "count is -1; expected a whole number, 0 or more"),
        ({"count": 2.5}, "count is 2.5"),
    ],
)
def test_values_of_the_wrong_shape_raise_errors(stage, arguments, message):
    with pytest.raises(GraphError, match=re.escape(message)) as caught:
        rep.create.cube(**arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rep.create.light(color=(1, 0)), "color is (1, 0); expected three numbers"),
        (lambda: rep.create.light(intensity="bright"), "inputs:intensity is a float; it does not take 'bright'"),
        (lambda: rep.create.light(light_type=7), "light_type=7; known: cylinder"),
        (lambda: rep.create.camera(focal_length=(1, 2)), "focalLength is a float; it does not take (1, 2)"),
        (lambda: rep.create.camera(clipping_range=(1, 2, 3)), "clipping_range is (1, 2, 3); expected two numbers"),
    ],
)
def test_invalid_values_of_lights_and_cameras_raise_errors(stage, make, message):
    with pytest.raises(GraphError, match=re.escape(message)):
        make()


def test_the_error_of_a_distribution_of_the_wrong_length_names_its_script_line(stage):
    rep.create.cube(position=rep.distribution.uniform((0, 0), (1, 1)))
    with pytest.raises(
        GraphError, match=r"made at test_values.py:\d+\): position is \[0\.\d+, 0\.\d+\]; expected three"
    ):
        evaluate.graph().evaluate()
    with rep.create.cube():
        rep.randomizer.color(colors=rep.distribution.uniform((0, 0), (1, 1)))
    with pytest.raises(GraphError, match=r"colors is \[0\.\d+, 0\.\d+\]; expected three numbers"):
        evaluate.graph().evaluate()


def test_scripts_that_catch_graph_errors_catch_wrong_arguments(stage):
    with pytest.raises(ArgumentError, match="count is -1") as caught:
        rep.create.cube(count=-1)
    assert isinstance(caught.value, GraphError)
