"""The functions of `rep.settings`: their effects on the settings and the stage."""

import pytest
from pxr import UsdGeom

import usdsdg as rep
from usdsdg.capture.render_settings import render_mode
from usdsdg.errors import ConfigError
from usdsdg.graph import evaluate
from usdsdg.session.settings.store import Settings, get_settings

pytestmark = pytest.mark.usefixtures("stage")

MODES = ("/rtx/rendermode", "/rtx/post/aa/op", "/rtx/pathtracing/totalSpp")


@pytest.mark.parametrize(("name", "number"), [("off", 0), ("TAA", 1), ("FXAA", 2), ("dlss", 3), ("DLAA", 4)])
def test_the_fast_mode_sets_render_mode_and_antialiasing(name, number):
    rep.settings.set_render_pathtraced()
    rep.settings.set_render_rtx_realtime(antialiasing=name)
    assert get_settings().get("/rtx/post/aa/op") == number
    assert not render_mode(1).path_tracing


def test_path_tracing_sets_render_mode_and_samples():
    rep.settings.set_render_pathtraced()
    assert (render_mode(1).path_tracing, render_mode(1).samples) == (True, 64)
    rep.settings.set_render_pathtraced(samples_per_pixel=7)
    assert render_mode(1).samples == 7


def test_units_and_up_axis_are_authored_on_the_stage(stage):
    rep.settings.set_stage_up_axis("y")
    rep.settings.set_stage_meters_per_unit(0.01)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    rep.settings.set_stage_up_axis("Z")
    assert UsdGeom.GetStageUpAxis(stage) == "Z"


def test_units_and_up_axis_are_those_of_the_root_layer_also_inside_of_a_new_layer(stage):
    with rep.new_layer() as layer:
        rep.settings.set_stage_up_axis("Y")
        rep.settings.set_stage_meters_per_unit(0.01)
        assert stage.GetEditTarget().GetLayer() == layer
    assert stage.GetRootLayer().pseudoRoot.GetInfo("upAxis") == "Y"
    assert stage.GetRootLayer().pseudoRoot.GetInfo("metersPerUnit") == 0.01


@pytest.mark.parametrize("value", [3, 0.5, True, "text", [1, 2], None])
def test_any_setting_can_be_written_and_read(value):
    rep.settings.carb_settings("rtx//some/thing/", value)
    assert get_settings().get("/rtx/some/thing") == value
    get_settings().destroy_item("/rtx/some")
    assert get_settings().get("/rtx/some/thing") is None


def test_typed_getters_convert_settings():
    settings = get_settings()
    settings.set("/rtx/some/number", 2.5)
    read = (settings.get_as_int, settings.get_as_float, settings.get_as_bool, settings.get_as_string)
    assert [get("/rtx/some/number") for get in read] == [2, 2.5, True, "2.5"]
    assert [get("/rtx/some/nothing") for get in read] == [0, 0.0, False, ""]
    write = {settings.set_int: 2, settings.set_float: 2.5, settings.set_bool: True, settings.set_string: "2.5"}
    for function, expected in write.items():
        function("/rtx/some/number", 2.5)
        assert settings.get("/rtx/some/number") == expected
    settings.set_default("/rtx/some/number", 1)
    assert settings.get("/rtx/some/number") == "2.5"
    defaults = {"int": 2, "float": 2.5, "bool": True, "string": "2.5"}
    for kind, expected in defaults.items():
        getattr(settings, f"set_default_{kind}")(f"/rtx/some/{kind}", 2.5)
        getattr(settings, f"set_default_{kind}")(f"/rtx/some/{kind}", 0)
        assert settings.get(f"/rtx/some/{kind}") == expected
    settings.destroy_item("/rtx/some")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("set_render_rtx_realtime", "FXA", "antialiasing is 'FXA'; expected one of off, taa, fxaa"),
        ("set_render_pathtraced", 0, "samples_per_pixel is 0; expected a whole number, 1 or more"),
        ("set_render_pathtraced", "many", "samples_per_pixel is 'many'"),
        ("set_stage_up_axis", "X", "up axis is 'X'; expected 'Y' or 'Z'"),
        ("set_stage_up_axis", 3, "up axis is 3"),
        ("set_stage_meters_per_unit", 0, "meters per unit is 0; expected a number above 0"),
        ("set_stage_meters_per_unit", "cm", "meters per unit is 'cm'"),
        ("set_physx_timestep", -1, "-1 must be above 0 seconds"),
        ("set_physx_timestep", "fast", "'fast' must be above 0 seconds"),
    ],
)
def test_invalid_values_raise_and_change_nothing(stage, name, value, message):
    before = {key: get_settings().get(key) for key in MODES}
    with pytest.raises(ConfigError, match=message) as caught:
        getattr(rep.settings, name)(value)
    assert isinstance(caught.value, ValueError)
    assert {key: get_settings().get(key) for key in MODES} == before
    assert (UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)) == ("Z", 1)
    assert not stage.GetPrimAtPath("/PhysicsScene")


def test_what_is_below_a_key_is_a_dictionary():
    settings = Settings()
    settings.set("/mine/size", 3)
    settings.set("mine/deep/name", "x")
    settings.set("/minerals", 1)
    assert settings.get("/mine") == {"size": 3, "deep": {"name": "x"}}
    assert settings.get("/mine/deep/") == {"name": "x"}
    assert settings.get("/mine/deeper") is None
    assert settings.get("/rtx/post")["tonemap"]["filmIso"] == 100


def test_a_dictionary_that_is_set_is_a_tree_of_settings():
    settings = Settings()
    settings.set("/mine", {"a": {"b": 1}, "c": 2})
    settings.set("/mine/a/b", 5)
    assert settings.get("/mine") == {"a": {"b": 5}, "c": 2}
    settings.set("/mine", {"d": 3})
    assert settings.get("/mine") == {"d": 3}
    settings.set("/rtx/pathtracing/spp", 9)
    settings.set("/rtx", {"rendermode": "PathTracing", "own": {"x": 1}})
    assert settings.get("/rtx/rendermode") == "PathTracing"
    assert settings.get("/rtx/own/x") == 1
    assert settings.get("/rtx/pathtracing/spp") == 1, "what has an effect has its default, not nothing"


def test_values_inside_of_a_dictionary_have_keys():
    settings = Settings()
    settings.set("/mine", {"a": {"b": 1}, "c": 2})
    assert settings.get("/mine/a/b") == 1
    assert settings.get("/mine/a") == {"b": 1}
    assert settings.get("/mine/c") == 2
    assert settings.get("/mine/c/d") is None
    assert settings.get("/mine/x/y") is None


def test_draws_for_integer_settings_are_integers():
    settings = get_settings()
    settings.set("/mine/on", True)
    for key in ("/rtx/pathtracing/totalSpp", "/mine/on", "/mine/new"):
        rep.settings.carb_settings(key, rep.distribution.choice([19.7]))
    evaluate.graph().evaluate()
    assert [repr(settings.get(f"/{key}")) for key in ("rtx/pathtracing/totalSpp", "mine/new")] == ["19", "19.7"]
    assert settings.get("/mine/on") == 19.7
