import pytest
from pxr import Sdf, Usd

from usdsdg.errors import BadPrim
from usdsdg.stage import paths


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    stage.SetDefaultPrim(stage.DefinePrim("/World", "Xform"))
    return stage


def test_a_free_path_is_returned_as_it_is(stage):
    assert paths.next_free_path(stage, "/World/mug") == "/World/mug"


def test_taken_paths_get_two_digit_suffixes(stage):
    taken = []
    for _ in range(12):
        taken.append(paths.next_free_path(stage, "/World/mug"))
        stage.DefinePrim(taken[-1])
    assert taken[:3] == ["/World/mug", "/World/mug_01", "/World/mug_02"]
    assert taken[-1] == "/World/mug_11"


def test_a_trailing_number_is_incremented(stage):
    for name in ("cam_0", "cam_01", "box_99", "part_7a"):
        stage.DefinePrim(f"/World/{name}")
    assert paths.next_free_path(stage, "/World/cam_0") == "/World/cam_02"
    assert paths.next_free_path(stage, "/World/box_99") == "/World/box_100"
    assert paths.next_free_path(stage, "/World/part_7a") == "/World/part_7a_01"


def test_the_first_gap_is_used(stage):
    for name in ("a", "a_01", "a_03"):
        stage.DefinePrim(f"/World/{name}")
    assert paths.next_free_path(stage, "/World/a") == "/World/a_02"


def test_many_free_paths_are_those_of_one_prim_after_the_other(stage):
    for name in ("a", "a_01", "a_03", "cam_07"):
        stage.DefinePrim(f"/World/{name}")
    for wanted in ("/World/a", "/World/new", "/World/cam_07", "/Nowhere/a"):
        found = paths.free_paths(stage, wanted, 12)
        for path in found:
            assert path == paths.next_free_path(stage, wanted)
            stage.DefinePrim(path)
    assert paths.free_paths(stage, "/World/a", 0) == []


def test_inactive_prims_count_as_taken(stage):
    stage.DefinePrim("/World/a").SetActive(False)
    assert paths.next_free_path(stage, Sdf.Path("/World/a")) == "/World/a_01"


def test_the_default_prim_is_prepended_once(stage):
    assert paths.next_free_path(stage, "/mug", True) == "/World/mug"
    assert paths.next_free_path(stage, "/World/mug", True) == "/World/mug"
    stage.DefinePrim("/World/mug")
    assert paths.next_free_path(stage, "/mug", True) == "/World/mug_01"
    stage.ClearDefaultPrim()
    assert paths.next_free_path(stage, "/mug", True) == "/mug"


@pytest.mark.parametrize("path", ["", "World/a", "/World/a.size", "/World/003_box", "/World/a b", "..", "/World/"])
def test_bad_paths_are_refused(stage, path):
    with pytest.raises(BadPrim):
        paths.next_free_path(stage, path)


def test_an_invalid_name_is_refused_with_a_valid_one(stage):
    with pytest.raises(BadPrim, match="'/World/_03_cracker_box'"):
        paths.next_free_path(stage, "/World/003_cracker_box")


def test_prim_at_says_how_far_the_path_exists(stage):
    stage.DefinePrim("/World/Cameras/cam_0")
    assert paths.prim_at(stage, "/World/Cameras/cam_0").GetName() == "cam_0"
    with pytest.raises(BadPrim, match=r"no prim /World/Cameras/cam_1/lens .* /World/Cameras has cam_0 below it"):
        paths.prim_at(stage, "/World/Cameras/cam_1/lens")
    with pytest.raises(BadPrim, match="/ has World below it"):
        paths.prim_at(stage, "/Word")
