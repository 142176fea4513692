"""`modify.attribute` on attributes of every kind of value."""

import numpy as np
import pytest
from pxr import Gf, Sdf

import usdsdg as rep
from usdsdg.errors import GraphError
from usdsdg.stage.attributes import set_value

Types = Sdf.ValueTypeNames
HALF = Gf.Quatd(0.5, 0.5, 0.5, 0.5)


def attribute(stage, type_name):
    return stage.DefinePrim("/thing", "Cube").CreateAttribute("value", type_name)


def after_a_firing(stage, type_name, value):
    made = attribute(stage, type_name)
    with rep.trigger.on_frame(), rep.get.prim_at_path("/thing"):
        rep.modify.attribute("value", value)
    rep.orchestrator.step()
    return made.Get()


@pytest.mark.parametrize(
    ("type_name", "value", "expected"),
    [
        (Types.Quatd, HALF, HALF),
        (Types.Quatf, (0.5, 0.5, 0.5, 0.5), Gf.Quatf(HALF)),
        (Types.QuathArray, [Gf.Quath(1), (0, 1, 0, 0)], [Gf.Quath(1), Gf.Quath(0, 1, 0, 0)]),
        (Types.Matrix3d, np.arange(9).reshape(3, 3), Gf.Matrix3d(*range(9))),
        (Types.Matrix4d, Gf.Matrix4d(3), Gf.Matrix4d(3)),
        (Types.Matrix4d, list(range(16)), Gf.Matrix4d(*range(16))),
        (Types.Matrix4dArray, [np.eye(4), Gf.Matrix4d(2)], [Gf.Matrix4d(1), Gf.Matrix4d(2)]),
        (Types.Int2, (2.9, -0.1), Gf.Vec2i(2, -1)),
        (Types.Int3Array, [(1.5, 2, -0.5)], [Gf.Vec3i(1, 2, -1)]),
        (Types.IntArray, [1.5, -0.5], [1, -1]),
        (Types.TimeCode, 4.0, 4.0),
    ],
    ids=lambda value: str(value)[:24],
)
def test_values_become_those_of_the_type(stage, type_name, value, expected):
    found = after_a_firing(stage, type_name, value)
    assert (list(found) if isinstance(expected, list) else found) == expected


def test_draws_for_vectors_of_integers_are_rounded_down(stage):
    low, high = after_a_firing(stage, Types.Int2, rep.distribution.uniform((0.1, 7.1), (0.9, 7.9)))
    assert (low, high) == (0, 7)


def test_a_value_of_a_saved_graph_is_that_of_the_script(stage):
    made = attribute(stage, Types.Quatd)
    with rep.trigger.on_frame(), rep.get.prim_at_path("/thing"):
        written = rep.modify.attribute("value", HALF)
    saved = stage.GetPrimAtPath(written.node.get_prim_path()).GetAttribute("inputs:value").Get()
    set_value(made, [float(each) for each in saved.strip("[]").split(",")])
    assert made.Get() == HALF


@pytest.mark.parametrize("value", [np.eye(3), [1, 2, 3], "one"])
def test_a_matrix_of_another_size_is_an_error(stage, value):
    with pytest.raises(GraphError, match="matrix4d"):
        after_a_firing(stage, Types.Matrix4d, value)
