"""Batched authoring of attributes against single writes."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.stage.attribute_batch import AttributeBatch, write_batch


def _attributes(stage: Usd.Stage, type_name: Sdf.ValueTypeName, count: int = 4) -> list[Usd.Attribute]:
    return [stage.DefinePrim(f"/prim_{i}").CreateAttribute("value", type_name) for i in range(count)]


@pytest.mark.parametrize(
    ("type_name", "values", "make"),
    [
        (Sdf.ValueTypeNames.Float, np.linspace(0.1, 0.7, 4), float),
        (Sdf.ValueTypeNames.Double, [0.1, 2, -3.0, 1e9], float),
        (Sdf.ValueTypeNames.Color3f, np.linspace(0, 1, 12).reshape(4, 3), lambda row: Gf.Vec3f(*map(float, row))),
        (Sdf.ValueTypeNames.Vector3f, np.arange(4.0) / 3, lambda one: Gf.Vec3f(float(one))),
        (Sdf.ValueTypeNames.Double3, [(0, 1, 2)] * 4, lambda row: Gf.Vec3d(*map(float, row))),
        (
            Sdf.ValueTypeNames.Color3fArray,
            np.linspace(0, 1, 12).reshape(4, 3),
            lambda row: [Gf.Vec3f(*map(float, row))],
        ),
        (
            Sdf.ValueTypeNames.TexCoord2fArray,
            np.linspace(0, 1, 24).reshape(4, 3, 2),
            lambda rows: [Gf.Vec2f(*map(float, row)) for row in rows],
        ),
        (Sdf.ValueTypeNames.FloatArray, np.linspace(0, 1, 8).reshape(4, 2), lambda row: list(map(float, row))),
        (Sdf.ValueTypeNames.Token, ["a", "b", "c", "d"], str),
    ],
)
def test_a_batch_writes_the_same_as_single_writes(type_name, values, make):
    one, all_ = Usd.Stage.CreateInMemory(), Usd.Stage.CreateInMemory()
    for attribute, value in zip(_attributes(one, type_name), values):
        attribute.Set(make(value))
    assert AttributeBatch(_attributes(all_, type_name)).write(values)
    assert all_.GetRootLayer().ExportToString() == one.GetRootLayer().ExportToString()


@pytest.mark.parametrize("values", [["a", "b", "c", "d"], [(1, 2)] * 4, [1.0, 2.0]])
def test_values_that_do_not_fit_are_left_to_single_writes(values):
    stage = Usd.Stage.CreateInMemory()
    batch = AttributeBatch(_attributes(stage, Sdf.ValueTypeNames.Color3f))
    before = stage.GetRootLayer().ExportToString()
    assert not batch.write(values)
    assert stage.GetRootLayer().ExportToString() == before


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (Sdf.ValueTypeNames.Color3fArray, [1.0, 2.0, 3.0, 4.0]),
        (Sdf.ValueTypeNames.Color3fArray, [[(1, 2, 3)], [(1, 2, 3)] * 2, [], []]),
        (Sdf.ValueTypeNames.Color3fArray, [(1, 2)] * 4),
        (Sdf.ValueTypeNames.FloatArray, [1.0, 2.0, 3.0, 4.0]),
        (Sdf.ValueTypeNames.FloatArray, [(1.0, 2.0)] * 3),
    ],
)
def test_arrays_that_do_not_fit_are_left_to_single_writes(kind, values):
    stage = Usd.Stage.CreateInMemory()
    batch = AttributeBatch(_attributes(stage, kind))
    before = stage.GetRootLayer().ExportToString()
    assert not batch.write(values)
    assert stage.GetRootLayer().ExportToString() == before


def test_whole_numbers_and_mixed_types_have_no_batch():
    stage = Usd.Stage.CreateInMemory()
    with pytest.raises(ValueError, match="int"):
        AttributeBatch(_attributes(stage, Sdf.ValueTypeNames.Int))
    state: dict = {}
    assert not write_batch(state, "values", lambda: _attributes(stage, Sdf.ValueTypeNames.Int), [1, 2, 3, 4])


def test_a_batch_is_made_again_after_prims_were_replaced_or_the_layer_changed():
    stage = Usd.Stage.CreateInMemory()
    state: dict = {}

    def find() -> list[Usd.Attribute]:
        return [stage.GetPrimAtPath(f"/prim_{i}").GetAttribute("value") for i in range(4)]

    _attributes(stage, Sdf.ValueTypeNames.Float)
    assert write_batch(state, "values", find, [1, 2, 3, 4])
    stage.RemovePrim("/prim_2")
    _attributes(stage, Sdf.ValueTypeNames.Float)
    assert write_batch(state, "values", find, [5, 6, 7, 8])
    assert [attribute.Get() for attribute in find()] == [5, 6, 7, 8]
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        assert write_batch(state, "values", find, [0, 0, 0, 0])
    assert stage.GetRootLayer().GetAttributeAtPath("/prim_1.value").default == 6
    assert stage.GetSessionLayer().GetAttributeAtPath("/prim_1.value").default == 0


def test_an_attribute_that_was_removed_is_written_again():
    """Also where others of the batch are written before it is found out."""
    stage = Usd.Stage.CreateInMemory()
    prims = [UsdGeom.Sphere.Define(stage, f"/ball_{i}") for i in range(3)]
    state: dict = {}

    def find() -> list[Usd.Attribute]:
        return [prim.GetRadiusAttr() for prim in prims]

    assert write_batch(state, "radius", find, [1.5, 2.5, 3.5])
    prims[1].GetPrim().RemoveProperty("radius")
    assert write_batch(state, "radius", find, [4.5, 5.5, 6.5])
    assert [attribute.Get() for attribute in find()] == [4.5, 5.5, 6.5]
