"""Many poses at once are what one pose at a time would be, whatever ops the prims have."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.stage.poses.pose_batch import Rotations, author_poses
from usdsdg.stage.poses.rotations import matrix_from_euler
from usdsdg.stage.poses.xform_ops import author_pose

DOUBLE, FLOAT, HALF = (
    UsdGeom.XformOp.PrecisionDouble,
    UsdGeom.XformOp.PrecisionFloat,
    UsdGeom.XformOp.PrecisionHalf,
)
PRECISIONS = st.sampled_from([DOUBLE, FLOAT])
ADDERS = ["AddTranslateOp", "AddOrientOp", "AddRotateXYZOp", "AddRotateZYXOp", "AddRotateYOp", "AddScaleOp"]
STACKS = st.lists(st.tuples(st.sampled_from(ADDERS), PRECISIONS), max_size=3, unique_by=lambda op: op[0]) | st.just(
    [("AddTransformOp", DOUBLE)]
)
NUMBERS = st.integers(-8, 8)
ROWS = st.tuples(NUMBERS, NUMBERS, NUMBERS)


def made(stage, stacks):
    prims = []
    for number, stack in enumerate(stacks):
        xform = UsdGeom.Xform.Define(stage, f"/prim_{number}")
        for adder, precision in stack:
            getattr(xform, adder)(precision)
        prims.append(xform.GetPrim())
    return prims


@settings(max_examples=60, deadline=None)
@given(stacks=st.lists(STACKS, min_size=1, max_size=4), data=st.data())
def test_a_batch_is_many_single_poses(stacks, data):
    stages = [Usd.Stage.CreateInMemory() for _ in range(2)]
    both = [made(stage, stacks) for stage in stages]
    count = len(stacks)
    for _ in range(2):
        rows = {
            role: np.array(data.draw(st.lists(ROWS, min_size=count, max_size=count)), np.float64)
            for role in data.draw(st.sets(st.sampled_from(["translate", "rotate", "scale"])))
        }
        if "scale" in rows:
            rows["scale"] = np.abs(rows["scale"]) + 1
        rotations = Rotations(degrees=rows["rotate"] * 10) if "rotate" in rows else None
        author_poses(both[0], translate=rows.get("translate"), rotate=rotations, scale=rows.get("scale"))
        for row, prim in enumerate(both[1]):
            parts = {role: rows[role][row].tolist() for role in ("translate", "scale") if role in rows}
            if "rotate" in rows:
                parts["rotate_xyz"] = (rows["rotate"][row] * 10).tolist()
            author_pose(prim, **parts)
        for one, other in zip(*both):
            names = [list(prim.GetAttribute("xformOpOrder").Get() or ()) for prim in (one, other)]
            assert names[0] == names[1]
            matrices = [np.array(UsdGeom.Xformable(prim).GetLocalTransformation()) for prim in (one, other)]
            np.testing.assert_allclose(*matrices, atol=2e-5)


@given(st.lists(st.tuples(*[st.floats(-400, 400)] * 3), min_size=1, max_size=5))
def test_angles_and_quaternions_are_the_same_rotation(rows):
    degrees = np.array(rows)
    from_angles = Rotations(degrees=degrees)
    from_quats = Rotations(quats=from_angles.quats() * 3.0)
    np.testing.assert_allclose(from_quats.matrices(), matrix_from_euler(degrees), atol=1e-9)
    np.testing.assert_array_equal(from_angles.euler("XYZ"), degrees)
    for order in ("XYZ", "ZXY"):
        np.testing.assert_allclose(
            matrix_from_euler(from_quats.euler(order), order), matrix_from_euler(degrees), atol=1e-9
        )


def test_half_precision_ops_keep_their_type():
    stage = Usd.Stage.CreateInMemory()
    (prim,) = made(stage, [[("AddTranslateOp", HALF), ("AddOrientOp", HALF), ("AddScaleOp", HALF)]])
    rows = np.array([[1.0, 2.0, 3.0]])
    author_poses([prim], translate=rows, rotate=Rotations(degrees=rows), scale=rows)
    kinds = [str(prim.GetAttribute(f"xformOp:{op}").GetTypeName()) for op in ("translate", "orient", "scale")]
    assert kinds == ["half3", "quath", "half3"]
    assert tuple(prim.GetAttribute("xformOp:translate").Get()) == (1, 2, 3)


def test_a_prim_that_cannot_be_posed_is_told():
    stage = Usd.Stage.CreateInMemory()
    scope = stage.DefinePrim("/scope", "Scope")
    with pytest.raises(BadPrim, match="/scope"):
        author_poses([scope], translate=np.zeros((1, 3)))


@pytest.mark.parametrize("name", ["xformOp:translate", "xformOpOrder"])
def test_ops_that_a_script_has_removed_are_added_again(name):
    stage = Usd.Stage.CreateInMemory()
    prims = made(stage, [[("AddTranslateOp", DOUBLE)]] * 3)
    author_poses(prims, translate=np.ones((3, 3)))
    prims[1].RemoveProperty(name)
    author_poses(prims, translate=np.full((3, 3), 7.0))
    places = [UsdGeom.Xformable(prim).GetLocalTransformation().ExtractTranslation() for prim in prims]
    assert places == [(7, 7, 7)] * 3
