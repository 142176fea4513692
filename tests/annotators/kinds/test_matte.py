import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdShade, Vt

from tests.annotators.ray_caster import add_cube, make_frame, new_stage
from tests.annotators.scenes import mask_of, street
from usdsdg import annotators
from usdsdg.errors import UsdsdgWarning, forget_warnings
from usdsdg.session import stage_context
from usdsdg.session.settings.store import get_settings

ROOT = "/rtx/pathtracing/multimatte"


@pytest.fixture(autouse=True)
def settings():
    forget_warnings()
    yield get_settings()
    for channel in range(24):
        get_settings().destroy_item(f"{ROOT}/channel{channel}")
    get_settings().set(f"{ROOT}/channelCount", 0)


@pytest.fixture
def stage():
    return stage_context.set_stage(street())


def give_id(prim, value, kind=Sdf.ValueTypeNames.Int, interpolation=UsdGeom.Tokens.constant) -> None:
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("multimatte_id", kind, interpolation).Set(value)


def bind(stage, path: str, *prims, matte_id: int | None = None) -> UsdShade.Material:
    material = UsdShade.Material.Define(stage, path)
    for prim in prims:
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    if matte_id is not None:
        material.GetPrim().CreateAttribute("multimatte_id", Sdf.ValueTypeNames.Int).Set(matte_id)
    return material


def matte(frame, number=0) -> np.ndarray:
    return annotators.get(f"PtMultiMatte{number}").compute(frame).data


def test_each_channel_is_the_mask_of_its_id(stage, settings):
    give_id(stage.GetPrimAtPath("/World/Apple1"), 7)
    give_id(stage.GetPrimAtPath("/World/Apple2"), 1000000)
    give_id(stage.GetPrimAtPath("/World/Pear"), 7)
    settings.set(f"{ROOT}/channelCount", 5)
    for channel, wanted in {0: 7, 1: 1000000, 2: 8, 3: 1000000, 4: -1}.items():
        settings.set(f"{ROOT}/channel{channel}", wanted)
    frame = make_frame(stage, (64, 48))
    first, second = matte(frame), matte(frame, 1)
    assert (first.dtype, first.shape) == (np.float16, (48, 64, 4))
    sevens = mask_of(frame, "/World/Apple1") | mask_of(frame, "/World/Pear")
    million = mask_of(frame, "/World/Apple2")
    nothing = np.zeros_like(million)
    assert sevens.any()
    assert million.any()
    for seen, wanted in ((first, [sevens, million, nothing]), (second, [million, nothing, nothing])):
        np.testing.assert_array_equal(seen[..., :3], np.stack(wanted, -1))
        assert (seen[..., 3] == 1).all()


def test_a_channel_shows_its_own_number_unless_it_is_told_another(stage, settings):
    give_id(stage.GetPrimAtPath("/World/Pear"), 23)
    settings.set(f"{ROOT}/channelCount", 1000)  # more than there are
    frame = make_frame(stage, (64, 48))
    np.testing.assert_array_equal(matte(frame, 7)[..., 2], mask_of(frame, "/World/Pear"))
    assert not any(matte(frame, number)[..., :3].any() for number in range(7))


def test_ids_are_inherited_and_the_nearest_counts(stage, settings):
    give_id(stage.GetPrimAtPath("/World"), 1)
    give_id(stage.GetPrimAtPath("/World/Apple1"), 2)
    settings.set(f"{ROOT}/channelCount", 3)
    frame = make_frame(stage, (64, 48))
    apple = mask_of(frame, "/World/Apple1")
    np.testing.assert_array_equal(matte(frame)[..., 2], apple)
    np.testing.assert_array_equal(matte(frame)[..., 1], (frame.aovs["instance"] >= 0) & ~apple)


def test_materials_give_ids_to_what_has_none_of_its_own(stage, settings):
    apple, pear = (stage.GetPrimAtPath(f"/World/{name}") for name in ("Apple1", "Pear"))
    bind(stage, "/World/Looks/Red", apple, pear, matte_id=0)
    bind(stage, "/World/Looks/Plain", stage.GetPrimAtPath("/World/Ground"))
    give_id(pear, 1)
    give_id(apple, -1)
    settings.set(f"{ROOT}/channelCount", 2)
    frame = make_frame(stage, (64, 48))
    np.testing.assert_array_equal(matte(frame)[..., 0], mask_of(frame, "/World/Apple1"))
    np.testing.assert_array_equal(matte(frame)[..., 1], mask_of(frame, "/World/Pear"))


def test_without_channels_it_says_what_to_set(stage, settings):
    frame = make_frame(stage, (9, 7))
    settings.set(f"{ROOT}/channelCount", 3)
    with pytest.warns(UsdsdgWarning, match="PtMultiMatte1 shows nothing.*channelCount is 3; set it to 4 or more"):
        assert not matte(frame, 1)[..., :3].any()


def test_ids_of_single_faces_are_pointed_out(settings):
    stage = stage_context.set_stage(new_stage())
    cube = add_cube(stage, "/World/Cube")
    give_id(cube, Vt.IntArray([1, 1, 2, 2, 1, 1]), Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.uniform)
    settings.set(f"{ROOT}/channelCount", 3)
    with pytest.warns(UsdsdgWarning, match=r"/World/Cube.primvars:multimatte_id has several ids"):
        assert not matte(make_frame(stage, (9, 7)))[..., :3].any()
    give_id(cube, Vt.IntArray([2, 2]), Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.uniform)
    assert matte(make_frame(stage, (9, 7)))[..., 2].any()


def test_materials_of_single_faces_are_pointed_out(settings):
    stage = stage_context.set_stage(new_stage())
    mesh = UsdGeom.Mesh.Define(stage, "/World/Mesh")
    mesh.CreateFaceVertexCountsAttr([3, 3])
    subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset("Half", [0])
    bind(stage, "/World/Looks/Red", subset.GetPrim(), matte_id=1)
    frame = make_frame(stage, (9, 7))
    frame = type(frame)(**{**vars(frame), "gprims": ("/World/Mesh",), "memo": {}})
    settings.set(f"{ROOT}/channelCount", 3)
    with pytest.warns(UsdsdgWarning, match=r"Mesh/Half: the multimatte_id of /World/Looks/Red does not reach"):
        assert not matte(frame)[..., :3].any()
