"""`omni.kit.stage_templates`: new stages of a kind."""

import asyncio

import pytest
from pxr import UsdGeom, UsdLux

from usdsdg.compat.omni.kit import stage_templates
from usdsdg.errors import ArgumentError
from usdsdg.session import stage_context
from usdsdg.session.new_stages import NewStage
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage


@pytest.fixture(autouse=True)
def _kinds_and_settings():
    yield
    stage_context.use_new_stages(NewStage.EMPTY)
    get_settings().set("/persistent/app/newStage/defaultTemplate", None)


def lights():
    return [str(prim.GetPath()) for prim in current_stage().Traverse() if prim.HasAPI(UsdLux.LightAPI)]


def test_a_new_stage_replaces_the_current_one():
    before = stage_context.new_stage()
    before.DefinePrim("/World/old")
    told = []
    assert stage_templates.new_stage(lambda *result: told.append((*result, current_stage() == before)))
    assert told == [(True, "", False)]
    assert lights() == []
    assert not stage_templates.stage_path_exists("/World/old")
    assert stage_templates.stage_path_exists("/World")


def test_templates_with_a_light_have_that_of_the_application():
    assert asyncio.run(stage_templates.new_stage_async(template="Sunlight")) == (True, "")
    assert lights() == ["/Environment/defaultLight"]
    stage_context.use_new_stages(NewStage.KIT)
    stage_templates.new_stage_with_callback(template="default stage")
    assert lights() == ["/Environment/defaultLight"]
    assert UsdGeom.GetStageUpAxis(current_stage()) == "Y"


@pytest.mark.parametrize("author", [lambda root: root, lambda root, context: f"{root}{context}"])
def test_a_script_registers_templates_of_its_own(author):
    def new_stage(*arguments):
        current_stage().DefinePrim(f"{author(*arguments)}/lab")

    takes = (lambda a: new_stage(a)) if author.__code__.co_argcount == 1 else (lambda a, b: new_stage(a, b))
    assert stage_templates.register_template("Lab", takes, 2)
    assert not stage_templates.register_template("lab", takes)
    assert "lab" in stage_templates.get_stage_template_list()[-1]
    get_settings().set("/persistent/app/newStage/defaultTemplate", "lab")
    stage_templates.new_stage(template=None)
    assert stage_templates.stage_path_exists("/World/lab")
    assert stage_templates.unregister_template("lab")
    assert not stage_templates.unregister_template("lab")
    with pytest.raises(ArgumentError, match="named 'sunligt'; did you mean sunlight"):
        stage_templates.new_stage(template="sunligt")
