"""Scripts on prims: when they start and end, and what is called in between."""

import pytest
from pxr import Sdf

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.replicator.behavior.utils.behavior_utils import add_behavior_script
from usdsdg.compat.omni.behavior.scripting.core import get_script_manager
from usdsdg.compat.omni.behavior.scripting.script_manager import CONSENT, SCRIPTS
from usdsdg.errors import AssetNotFound, UsdsdgWarning
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import new_stage, open_stage
from usdsdg.session.timeline import get_timeline

LOGGER = """
from usdsdg.compat.omni.behavior.scripting.core import BehaviorScript

calls = []

class Base(BehaviorScript):
    pass

class Logger(Base):
    def on_init(self): calls.append(("init", str(self.prim_path), bool(self.prim)))
    def on_destroy(self): calls.append(("destroy", str(self.prim_path), bool(self.prim)))
    def on_play(self): calls.append("play")
    def on_pause(self): calls.append("pause")
    def on_stop(self): calls.append("stop")
    def on_update(self, current_time, delta_time): calls.append((round(current_time, 6), round(delta_time, 6)))
"""


@pytest.fixture
def logger(tmp_path):
    file = tmp_path / "logger.py"
    file.write_text(LOGGER)
    return str(file)


def _calls(path: str) -> list:
    import sys

    (script,) = get_script_manager().scripts(path)
    return sys.modules[type(script).__module__].calls


def test_a_script_lives_from_the_update_after_it_is_named_until_it_is_taken_off(stage, logger):
    prim = stage.DefinePrim("/World/A", "Xform")
    add_behavior_script(prim, logger)
    assert get_script_manager().scripts("/World/A") == []
    get_app().update()
    calls = _calls("/World/A")
    assert calls == [("init", "/World/A", True)]
    prim.GetAttribute(SCRIPTS).Set(Sdf.AssetPathArray())
    get_app().update()
    assert calls[1:] == [("destroy", "/World/A", True)]
    assert get_script_manager().scripts("/World/A") == []


def test_the_timeline_drives_scripts(stage, logger):
    add_behavior_script(stage.DefinePrim("/World/A", "Xform"), logger)
    timeline = get_timeline()
    timeline.play()
    calls = _calls("/World/A")
    get_app().update()
    timeline.pause()
    get_app().update()
    timeline.play()
    get_app().update()
    timeline.stop()
    get_app().update()
    step = round(1 / 60, 6)
    assert calls[1:] == ["play", (step, step), "pause", "play", (round(2 / 60, 6), step), "stop"]


def test_each_prim_has_its_own_script_and_the_same_file_is_attached_once(stage, logger):
    for path in ("/World/A", "/World/B"):
        prim = stage.DefinePrim(path, "Xform")
        add_behavior_script(prim, logger)
        add_behavior_script(prim, logger)
    get_app().update()
    one, other = get_script_manager().scripts("/World/A"), get_script_manager().scripts("/World/B")
    assert len(one) == len(other) == 1
    assert one[0] is not other[0]
    assert type(one[0]) is type(other[0])
    assert type(one[0]).__name__ == "Logger"


def test_scripts_end_with_their_prim_and_with_their_stage(stage, logger):
    for path in ("/World/A", "/World/B"):
        add_behavior_script(stage.DefinePrim(path, "Xform"), logger)
    get_app().update()
    calls = _calls("/World/A")
    stage.RemovePrim("/World/A")
    get_app().update()
    assert calls[2:] == [("destroy", "/World/A", False)]
    new_stage()
    assert calls[3:] == [("destroy", "/World/B", True)], "its prim is still there"


def test_a_script_of_a_playing_timeline_stops_before_it_ends_with_its_stage(stage, logger):
    add_behavior_script(stage.DefinePrim("/World/A", "Xform"), logger)
    get_app().update()
    calls = _calls("/World/A")
    get_timeline().play()
    new_stage()
    assert calls == [("init", "/World/A", True), "play", "stop", ("destroy", "/World/A", True)]


def test_scripts_that_come_with_a_stage_run_only_with_consent(stage, logger, tmp_path):
    prim = stage.DefinePrim("/World/A", "Xform")
    prim.CreateAttribute(SCRIPTS, Sdf.ValueTypeNames.AssetArray).Set(Sdf.AssetPathArray([logger]))
    file = str(tmp_path / "scene.usda")
    stage.Export(file)
    get_script_manager()
    open_stage(file)
    with pytest.warns(UsdsdgWarning, match="logger.py, which was not run, because it comes with the stage"):
        get_app().update()
    assert get_script_manager().scripts("/World/A") == []
    new_stage()
    get_settings().set(CONSENT, True)
    open_stage(file)
    get_app().update()
    assert _calls("/World/A") == [("init", "/World/A", True)]


def test_a_script_that_does_not_exist_is_an_error(stage):
    add_behavior_script(stage.DefinePrim("/World/A", "Xform"), "/nowhere/script.py")
    with pytest.raises(AssetNotFound, match="no file for /nowhere/script"):
        get_app().update()
