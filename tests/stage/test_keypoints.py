"""Keypoints on prims: written, read, saved, inherited through references, and edited."""

import pytest
from pxr import Gf, Sdf, Usd

import usdsdg as rep
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.keypoints import get_keypoints, set_keypoints


def test_keypoints_are_saved_and_come_with_references_and_instances(tmp_path):
    asset = Usd.Stage.CreateNew(str(tmp_path / "cup.usda"))
    cup = asset.DefinePrim("/cup", "Xform")
    set_keypoints(cup, {"rim": (0, 0, 2), "handle": (1, 0, 0.5)})
    asset.SetDefaultPrim(cup)
    asset.Save()
    stage = Usd.Stage.CreateInMemory()
    for path, instanceable in (("/a", False), ("/b", True)):
        prim = stage.DefinePrim(f"{path}/cup", "Xform")
        prim.GetReferences().AddReference(str(tmp_path / "cup.usda"))
        prim.SetInstanceable(instanceable)
        assert get_keypoints(prim) == {"handle": (1, 0, 0.5), "rim": (0, 0, 2)}


def test_points_are_added_replaced_and_removed():
    stage = new_stage()
    prims = [stage.DefinePrim(f"/World/{name}", "Cube") for name in "ab"]
    rep.functional.modify.keypoints(prims, {"top": (0, 0, 1)})
    rep.functional.modify.keypoints("/World/a", {"top": (0, 0, 2), "side": [1, 0, 0]})
    assert get_keypoints(prims[0]) == {"side": (1, 0, 0), "top": (0, 0, 2)}
    assert get_keypoints(prims[1]) == {"top": (0, 0, 1)}
    rep.functional.modify.keypoints("/World/a", {"side": (2, 0, 0)}, mode="replace")
    assert get_keypoints(prims[0]) == {"side": (2, 0, 0)}


def test_points_of_a_reference_can_be_removed():
    keep = Sdf.Layer.CreateAnonymous(".usda")
    asset, stage = Usd.Stage.Open(keep), Usd.Stage.CreateInMemory()
    set_keypoints(asset.DefinePrim("/cup"), {"rim": (0, 0, 1)})
    prim = stage.DefinePrim("/a")
    prim.GetReferences().AddReference(keep.identifier, "/cup")
    set_keypoints(prim, {}, replace=True)
    assert get_keypoints(prim) == {}


def test_time_samples_are_read_at_their_time():
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/a")
    set_keypoints(prim, {"tip": (0, 0, 0)})
    attribute = prim.GetAttribute("usdsdg:keypoints:tip")
    attribute.Set(Gf.Vec3d(0, 0, 1), 0)
    attribute.Set(Gf.Vec3d(0, 0, 3), 10)
    assert get_keypoints(prim, Usd.TimeCode(5)) == {"tip": (0, 0, 2)}


@pytest.mark.parametrize(
    ("value", "mode", "message"),
    [
        ({"left eye": (0, 0, 0)}, "add", "'left eye' cannot name a keypoint"),
        ({"eye": (0, 0)}, "add", "'eye' is .* expected three numbers"),
        ([(0, 0, 0)], "add", "expected {'name'"),
        ({}, "clear", "'add' or 'replace'"),
    ],
)
def test_other_values_are_refused(value, mode, message):
    new_stage().DefinePrim("/World/a", "Cube")
    with pytest.raises(ArgumentError, match=message):
        rep.functional.modify.keypoints("/World/a", value, mode)


def test_prims_inside_instances_are_refused():
    stage = new_stage()
    stage.DefinePrim("/Asset/mesh", "Cube")
    instance = stage.DefinePrim("/World/a", "Xform")
    instance.GetReferences().AddInternalReference("/Asset")
    instance.SetInstanceable(True)
    with pytest.raises(BadPrim, match="lies inside an instance"):
        set_keypoints(stage.GetPrimAtPath("/World/a/mesh"), {"top": (0, 0, 1)})
