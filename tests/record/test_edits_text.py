"""Texts of edits: those that USD writes for a layer with the same edits."""

import numpy as np
import pytest
from pxr import Gf, Sdf

from usdsdg.capture.records.edits_text import Edit, EditsText

TYPES = Sdf.ValueTypeNames
NUMBERS = (0.0, -0.0, 1.0, 0.1, -2.5, 1e-7, 1e-5, 123456789.125, 1e16, 1e22, 1e300, float("inf"), -float("inf"))


def exported(edits: list[Edit]) -> str:
    """Return the text that USD writes."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    for path, kind, value in edits:
        if kind is None:
            prim = Sdf.CreatePrimInLayer(layer, path.GetPrimPath())
            Sdf.RelationshipSpec(prim, path.name, custom=False).targetPathList.explicitItems = value
        else:
            Sdf.JustCreatePrimAttributeInLayer(layer, path, kind)
            layer.GetAttributeAtPath(path).default = value
    return layer.ExportToString()


def poses(generator: np.random.Generator) -> list[Edit]:
    """Return edits of nested prims, with a property of a prim that has children, in the order of paths."""
    edits: list[Edit] = [(Sdf.Path("/World.size"), TYPES.Float, float(np.float32(generator.uniform())))]
    for prim in ("/Other/Part", "/World", "/World/Arm", "/World/Arm/Hand", "/World/Box_1", "/World/Box_10"):
        turn, place = generator.uniform(-360, 360, 3), generator.uniform(-1e3, 1e3, 3)
        edits.append((Sdf.Path(f"{prim}.xformOp:translate"), TYPES.Double3, Gf.Vec3d(*place)))
        edits.append((Sdf.Path(f"{prim}.xformOp:rotateXYZ"), TYPES.Float3, Gf.Vec3f(*turn)))
        edits.append((Sdf.Path(f"{prim}.xformOp:orient"), TYPES.Quatf, Gf.Quatf(*generator.normal(size=4))))
    return sorted(edits, key=lambda edit: edit[0])


def test_text_is_that_of_usd_whatever_the_values() -> None:
    generator, texts = np.random.default_rng(5), EditsText()
    for _ in range(30):
        edits = poses(generator)
        assert texts.of(edits) == exported(edits)
    assert texts._template is not None  # the others were made without a layer


@pytest.mark.parametrize("number", NUMBERS)
def test_numbers_have_the_digits_of_usd(number: float) -> None:
    single = float(np.float32(number)) if abs(number) < 1e38 or np.isinf(number) else 3.5
    half = float(np.float16(number)) if abs(number) < 6e4 or np.isinf(number) else 3.5
    texts = EditsText()
    for factor in (0.5, 1.0):  # the second by the template of the first
        edits: list[Edit] = [
            (Sdf.Path("/A.d"), TYPES.Double, factor * number),
            (Sdf.Path("/A.f"), TYPES.Float, factor * single),
            (Sdf.Path("/A.h"), TYPES.Half, factor * half),
            (Sdf.Path("/A.v"), TYPES.Color3f, Gf.Vec3f(factor * single, 0.1, -0.0)),
            (Sdf.Path("/A.w"), TYPES.Vector3d, Gf.Vec3d(factor * number, 0.1, -0.0)),
            (Sdf.Path("/A.m"), TYPES.Matrix4d, Gf.Matrix4d(factor * single)),
        ]
        assert texts.of(edits) == exported(edits)
    assert texts._template is not None


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (TYPES.Bool, (False, True)),
        (TYPES.Int, (1, -7)),
        (TYPES.UInt64, (1, 1 << 40)),
        (TYPES.Token, ("inherited", "invisible", 'a "quoted" \\ one', "one\ntwo", "größer", "")),
        (TYPES.String, ("a label", "it's", "a % b", "%s", "{}")),
        (TYPES.Asset, (Sdf.AssetPath("a.png"), Sdf.AssetPath("b@c.png"))),
        (TYPES.TokenArray, (["a"], ["b", "c"])),
        (TYPES.FloatArray, ([0.5], [])),
        (TYPES.TimeCode, (Sdf.TimeCode(1.0), Sdf.TimeCode(2.5))),
        (None, ([Sdf.Path("/Looks/A")], [Sdf.Path("/Looks/B"), Sdf.Path("/Looks/C")])),
    ],
)
def test_types_that_are_no_numbers(kind: Sdf.ValueTypeName | None, values: tuple) -> None:
    texts = EditsText()
    for value in (*values, *values):
        edits: list[Edit] = [(Sdf.Path("/A/B.name"), kind, value), (Sdf.Path("/A/B.size"), TYPES.Double, 2.0)]
        assert texts.of(edits) == exported(edits)


def test_other_properties_after_each_other() -> None:
    generator, texts = np.random.default_rng(6), EditsText()
    for _ in range(3):
        many, few = poses(generator), poses(generator)[3:]
        for edits in (many, few, few, [], many):
            assert texts.of(edits) == exported(edits)
