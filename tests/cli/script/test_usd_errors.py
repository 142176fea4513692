"""USD's own errors in a script are printed with what they mean."""

import pytest
from click.testing import CliRunner

from usdsdg.cli.app import app
from usdsdg.session import session

TAKEN = """
import omni.usd
context = omni.usd.get_context()
stage = context.get_stage()
prim = stage.DefinePrim("/World/box", "Cube")
"""


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('stage.GetPrimAtPath("/World/bix").GetAttribute("size")', "There was no prim where the script looked for it"),
        ('stage.RemovePrim("/World/box"); prim.GetAttribute("size")', "The prim /World/box was removed"),
        ('context.new_stage(); stage.GetPrimAtPath("/World")', "Take it again: stage = omni.usd.get_context()"),
        (
            'def use(old):\n    context.new_stage()\n    old.GetPrimAtPath("/World")\n\nuse(context.get_stage())',
            "The stage in `old` has been closed",
        ),
    ],
)
def test_what_usd_says_has_a_remedy(tmp_path, lines, said):
    script = tmp_path / "script.py"
    script.write_text(TAKEN + lines)
    done = CliRunner().invoke(app, ["run", "-q", str(script)])
    session.restart()
    assert done.exit_code == 1
    assert said in done.output


@pytest.mark.parametrize("line", ['raise RuntimeError("Accessed nothing")', "stage.GetPrimAtPath(1)"])
def test_other_errors_are_left_as_they_are(tmp_path, line):
    script = tmp_path / "script.py"
    script.write_text(TAKEN + line)
    done = CliRunner().invoke(app, ["run", "-q", str(script)])
    session.restart()
    assert done.exit_code == 1
    assert "omni.usd.get_context().get_stage()" not in done.output
