"""Xforms of created objects: the values of their xform ops, their names and their parents."""

import numpy as np
import pytest
from pxr import Gf

import usdsdg as rep
from usdsdg.errors import UsdsdgWarning

OPS = {"xformOp:translate": (0, 0, 0), "xformOp:rotateXYZ": (0, 0, 0), "xformOp:scale": (1, 1, 1)}


def ops_of(prim):
    return {name: tuple(prim.GetAttribute(name).Get()) for name in prim.GetAttribute("xformOpOrder").Get()}


@pytest.mark.parametrize("kind", ["cube", "xform", "light", "camera"])
def test_ops_of_new_objects_have_values(stage, kind):
    prims = getattr(rep.create, kind)(count=3).get_output_prims()["prims"]
    assert len(prims) == 3
    for prim in prims:
        assert ops_of(prim) == OPS
        prim.GetAttribute("xformOp:translate").Set(Gf.Vec3d(1, 2, 3))
        assert prim.GetAttribute("xformOp:rotateXYZ").GetTypeName() == "float3"


def test_constants_and_values_of_each_are_written_to_these_ops(stage):
    one = rep.create.cube(position=(1, 2, 3), rotation=[4, 5, 6], scale=2, count=3).get_output_prims()["prims"]
    expected = {"xformOp:translate": (1, 2, 3), "xformOp:rotateXYZ": (4, 5, 6), "xformOp:scale": (2, 2, 2)}
    assert [ops_of(prim) for prim in one] == [expected] * 3
    own = rep.create.cube(position=[(1, 2, 3), (4, 5, 6)], count=2).get_output_prims()["prims"]
    assert [ops_of(prim)["xformOp:translate"] for prim in own] == [(1, 2, 3), (4, 5, 6)]
    looking = rep.create.cube(position=(0, 5, 0), look_at=(0, 0, 0)).get_output_prims()["prims"][0]
    assert list(ops_of(looking)) == list(OPS)
    assert not np.allclose(ops_of(looking)["xformOp:rotateXYZ"], 0)


@pytest.mark.parametrize(("name", "valid"), [("a-b", "a_b"), ("123xyx", "_23xyx")])
def test_names_are_made_valid(stage, name, valid):
    with pytest.warns(UsdsdgWarning, match=f"it is called {valid} instead"):
        item = rep.create.cube(name=name, count=2)
    assert item.prims == (f"/Replicator/{valid}_Xform", f"/Replicator/{valid}_Xform_01")
    assert stage.GetPrimAtPath(f"/Replicator/{valid}_Xform_01/{valid}")


def test_an_empty_transform_has_its_own_name(stage):
    assert rep.create.xform(name="xt").prims == ("/Replicator/xt",)
    assert rep.create.xform(count=2).prims == ("/Replicator/Xform", "/Replicator/Xform_01")


def test_nothing_is_created_below_a_shape(stage):
    cube = rep.create.cube().get_output_prims()["prims"][0].GetChild("Cube")
    for create in (rep.create.sphere, rep.create.xform):
        with pytest.raises(ValueError, match="does not allow prims below shapes"):
            create(parent=cube)
