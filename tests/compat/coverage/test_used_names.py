"""Scripts are read without running them: aliases are resolved, and the modules beside them are read as well."""

import textwrap
from pathlib import Path

import pytest

from usdsdg.compat.coverage.used_names import Use, uses_of
from usdsdg.errors import ConfigError


@pytest.fixture
def used(tmp_path):
    """A function that writes a script and returns its uses as {name: lines}."""

    def read(text, helpers=None):
        for name, code in (helpers or {}).items():
            path = tmp_path / name
            path.parent.mkdir(exist_ok=True)
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
        "omni.timeline.get_timeline_interface",
    }  # fmt: skip
    assert found["omni.replicator.core.create.sphere"] == [("script.py", 8)]


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


def test_uses_are_sorted():
    assert sorted([Use("b", "f", 1), Use("a", "f", 2)])[0].name == "a"
