"""Names that a script lacks are said before it starts, and only what it is sure to need stops it."""

import textwrap

import pytest

from tests.scripts.conftest import usdsdg
from usdsdg import compat
from usdsdg.cli.script.missing_names import missing_names


@pytest.fixture(autouse=True)
def _names():
    compat.install()


def found(folder, text: str) -> tuple[list[str], list[str]]:
    script = folder / "script.py"
    script.write_text("import omni.replicator.core as rep\nimport omni.ui as ui\n" + textwrap.dedent(text))
    return missing_names(script)


@pytest.mark.parametrize(
    "text",
    [
        "rep.create.lamp()",
        "def main():\n    rep.create.lamp()\nmain()",
        "def main():\n    rep.create.lamp()\nif __name__ == '__main__':\n    main()",
        "for _ in range(3):\n    rep.create.lamp()",
        "import asyncio\nasync def main():\n    rep.create.lamp()\nasyncio.ensure_future(main())",
        "create = rep.create\ncreate.lamp()",
        "from omni.replicator.core.create import lamp",
    ],
)
def test_what_a_script_is_sure_to_need_stops_it(tmp_path, text):
    fatal, possible = found(tmp_path, text)
    assert len(fatal) == 1
    assert "lamp" in fatal[0]
    assert not possible


@pytest.mark.parametrize(
    "text",
    [
        "def never_called():\n    rep.create.lamp()",
        "if rep.get_global_seed():\n    rep.create.lamp()",
        "light = rep.create.lamp() if rep.get_global_seed() else None",
        "try:\n    rep.create.lamp()\nexcept Exception:\n    pass",
        "import contextlib\nwith contextlib.suppress(AttributeError):\n    rep.create.lamp()",
        "def use(rep):\n    rep.create.lamp()\nuse(None)",
        "timeline = rep.create\ntimeline = None\ntimeline.lamp()",
        "rep.AnnotatorRegistry.get_annotator('mine')",  # which another module may register
        "rep.create.lamp = print\nrep.create.lamp()",
        "class Window(ui.Window):\n    pass",
        "def layout() -> ui.Window: ...",
    ],
)
def test_what_it_may_not_need_does_not(tmp_path, text):
    fatal, _ = found(tmp_path, text)
    assert fatal == []


def test_calls_of_what_is_out_of_scope_stop_it_with_the_reason_once(tmp_path):
    fatal, _ = found(tmp_path, "window = ui.Window('a')\nbutton = ui.Button('b')")
    assert fatal[0].startswith("script.py:3: `window = ui.Window('a')` needs omni.ui.Window, which usdsdg leaves out: ")
    assert fatal[1] == "script.py:4: `button = ui.Button('b')` needs omni.ui.Button, which usdsdg leaves out"


def test_the_script_does_not_start_unless_lenient(tmp_path):
    (tmp_path / "script.py").write_text(
        "import omni.replicator.core as rep\nopen('started', 'w').close()\nrep.create.lamp()\n"
    )
    done = usdsdg("run", "script.py", cwd=tmp_path, expect=1)
    assert "the script was not started" in done.stderr
    assert "script.py:3: `rep.create.lamp()` needs omni.replicator.core.create.lamp" in done.stderr
    assert not (tmp_path / "started").exists()
    usdsdg("run", "--lenient", "script.py", cwd=tmp_path, expect=1)
    assert (tmp_path / "started").exists()


@pytest.mark.parametrize(
    ("text", "version"),
    [
        ("try:\n    import isaacsim.core.utils.stage\nexcept ImportError:\n    import omni.isaac.core.utils.stage", 6),
        ("from omni.isaac.core.utils.stage import get_current_stage", 4),
        ("from omni.isaac import nucleus", 4),
    ],
)
def test_looking_names_up_does_not_choose_the_payloads(tmp_path, text, version):
    tell = "from usdsdg.session.settings.replicator_version import replicator_version\nprint(replicator_version())"
    (tmp_path / "script.py").write_text(f"import omni.replicator.core as rep\n{text}\n{tell}\n")
    assert usdsdg("run", "script.py", cwd=tmp_path).stdout.split() == [str(version)]
