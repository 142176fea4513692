"""Scripts are read without running them: aliases are resolved, and the modules beside them are read as well."""

import importlib
import textwrap
import types
from pathlib import Path

import pytest

from usdsdg.compat import finder
from usdsdg.compat.coverage.used_names import GETTERS, Use, uses_of
from usdsdg.compat.coverage.verdicts import MISSING, OUT_OF_SCOPE, SUPPORTED, verdict
from usdsdg.errors import ConfigError, Unsupported


@pytest.fixture
def used(tmp_path):
    """A function that writes a script and returns its uses as {name: lines}."""

    def read(text, helpers=None):
        for name, code in (helpers or {}).items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(textwrap.dedent(code))
        script = tmp_path / "script.py"
        script.write_text(textwrap.dedent(text))
        found = {}
        for use in uses_of([script]):
            found.setdefault(use.name, []).append((use.file.removeprefix(f"{tmp_path}/"), use.line))
        return found

    return read


def test_aliases_stand_for_what_they_were_made_from(used):
    found = used(
        """
        import omni.usd as u, omni.timeline
        from isaacsim.core.utils import stage as tools
        import omni.replicator.core as rep
        with rep.trigger.on_frame():
            rep.create.cube()
        create = rep.create
        create.sphere(position=u.get_context())
        tools.open_stage("a.usd").GetPrim().IsValid()
        omni.timeline.get_timeline_interface().play()
        """
    )
    assert set(found) == {
        "omni.usd", "omni.timeline", "isaacsim.core.utils.stage", "omni.replicator.core", "omni.usd.get_context",
        "omni.replicator.core.trigger.on_frame", "omni.replicator.core.create.cube", "omni.replicator.core.create",
        "omni.replicator.core.create.sphere", "isaacsim.core.utils.stage.open_stage",
        "omni.timeline.get_timeline_interface", "omni.timeline.ITimeline.play",
    }  # fmt: skip
    assert found["omni.replicator.core.create.sphere"] == [("script.py", 8)]


def test_packages_of_the_script_may_have_names_of_omniverse(used):
    found = used(
        """
        import omni.usd, omni.acme.tools
        from isaacsim.ocean.sensors.sonar import Sonar
        from isaacsim.other import thing
        Sonar().ping(omni.acme.tools.size)
        """,
        {
            "isaacsim/ocean/sensors/sonar.py": "import omni.timeline",
            "omni/acme/tools.py": "size = 3",
        },
    )
    assert found == {
        "omni.usd": [("script.py", 2)],
        "isaacsim.other.thing": [("script.py", 4)],
        "omni.timeline": [("isaacsim/ocean/sensors/sonar.py", 1)],
    }


def test_imports_inside_functions_count_and_other_packages_do_not(used):
    found = used(
        """
        import numpy as np
        from pxr import Gf, PhysxSchema
        def main():
            from omni.physx import get_physx_interface as physx
            return physx(), np.zeros(3), Gf.Vec3d(0), PhysxSchema.PhysxSceneAPI
        """
    )
    names = {"omni.physx.get_physx_interface", "pxr.PhysxSchema", "pxr.PhysxSchema.PhysxSceneAPI"}
    assert set(found) == names


def test_members_of_registries_are_names_of_their_own(used):
    found = used(
        """
        import omni.replicator.core as rep
        class Mine(rep.Writer): ...
        rep.WriterRegistry.register(Mine)
        rep.WriterRegistry.get("Mine"), rep.writers.get("BasicWriter")
        rep.AnnotatorRegistry.get_annotator("rgb"), rep.annotators.get(name)
        def shapes(): ...
        rep.randomizer.register(shapes)
        rep.randomizer.shapes()
        rep.randomizer.color()
        """
    )
    assert {name for name in found if "('" in name} == {"writers.get('BasicWriter')", "annotators.get('rgb')"}
    assert {name for name in found if "randomizer" in name} == {
        "omni.replicator.core.randomizer.register",
        "omni.replicator.core.randomizer.color",
    }


def test_annotators_that_a_script_registers_by_name_are_its_own(used):
    found = used(
        """
        import omni.replicator.core as rep
        rep.annotators.register("inverted", rep.annotators.augment("rgb", lambda data: 255 - data))
        rep.AnnotatorRegistry.register_annotator_from_aov("Mine", None)
        rep.annotators.get("inverted"), rep.AnnotatorRegistry.get_annotator("Mine"), rep.annotators.get("invertd")
        """
    )
    assert {name for name in found if "('" in name} == {"annotators.get('invertd')"}


def test_modules_beside_a_script_are_read_once(used):
    found = used(
        """
        import helper
        from tools.inner import thing
        """,
        {
            "helper.py": "import script, omni.client\nomni.client.list('x')\n",
            "tools/__init__.py": "import carb",
            "tools/inner.py": "from . import other\n",
            "tools/other.py": "import usdrt\n",
        },
    )
    assert found["omni.client.list"] == [("helper.py", 2)]
    assert {"carb", "usdrt"} <= set(found)


@pytest.mark.parametrize(
    ("text", "words"), [("def f(:\n", "line 1: not Python"), ("a = '\0'", "cannot be read|not Python")]
)
def test_files_that_are_not_python_are_errors(used, text, words):
    with pytest.raises(ConfigError, match=words):
        used(text)
    with pytest.raises(ConfigError, match="cannot be read"):
        uses_of([Path("nothing.py")])


def test_files_that_are_not_python_leave_the_others(tmp_path):
    wrong, right, helper = tmp_path / "wrong.py", tmp_path / "right.py", tmp_path / "helper.py"
    wrong.write_text("def (")
    helper.write_text("print 'of Python 2'")
    right.write_text("import helper, omni.usd")
    unread = {}
    assert [use.name for use in uses_of([wrong, right], unread)] == ["omni.usd"]
    assert set(unread) == {wrong, helper}
    assert "line 1: not Python" in str(unread[wrong])


def test_uses_are_sorted():
    assert sorted([Use("b", "f", 1), Use("a", "f", 2)])[0].name == "a"


def test_members_of_what_well_known_functions_return_are_names_of_its_class(used):
    found = used(
        """
        import carb, omni.usd, omni.kit.app
        from omni.timeline import get_timeline_interface
        omni.usd.get_context().get_rendering_event_stream().create_subscription_to_pop(print)
        settings = carb.settings.get_settings()
        settings.set("/a", 1)
        class Script:
            def __init__(self):
                self._timeline = get_timeline_interface()
                app = omni.kit.app.get_app()
                app.update()
            def run(self, settings):
                self._timeline.play()
                settings.fly()
                app.swim()
                self._app.dive()
        settings = make()
        settings.walk()
        """
    )
    assert set(found) == {
        "carb", "carb.settings.ISettings.set", "carb.settings.get_settings", "omni.kit.app", "omni.kit.app.IApp.update",
        "omni.kit.app.get_app", "omni.timeline.ITimeline.play", "omni.timeline.get_timeline_interface", "omni.usd",
        "omni.usd.UsdContext.get_rendering_event_stream", "omni.usd.get_context",
    }  # fmt: skip
    assert found["omni.timeline.ITimeline.play"] == [("script.py", 13)]


@pytest.mark.parametrize("getter", sorted(GETTERS))
def test_the_class_of_what_a_function_returns_is_known_by_its_name(getter):
    assert verdict(getter).state == verdict(GETTERS[getter]).state == SUPPORTED
    assert verdict(f"{GETTERS[getter]}.fly_to_the_moon").state == MISSING


def test_members_of_values_that_have_none_are_missing():
    assert verdict("omni.kit.app.GLOBAL_EVENT_UPDATE.flight").state == MISSING


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("isaacsim.sensors.experimental.rtx", "RtxCamera"),  # of a module that is out of scope
        ("omni.isaac.sensor", "LidarRtx"),  # of one that is here
    ],
)
def test_judging_a_name_out_of_scope_leaves_it_a_class_for_the_script(module, name):
    finder.install()
    assert verdict(f"{module}.{name}").state == OUT_OF_SCOPE
    made = getattr(importlib.import_module(module), name)
    derived = types.new_class("Derived", (made,))
    assert not isinstance(3, made)
    for called in (made, derived):
        with pytest.raises(Unsupported, match=f"{module}.{name}"):
            called("/World/camera")
