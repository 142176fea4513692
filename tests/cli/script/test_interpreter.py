"""A process that has run a script is not taken for that script later on."""

import sys

import pytest
from click.testing import CliRunner

from usdsdg.cli.app import app
from usdsdg.session import session
from usdsdg.session.session import current

SCRIPT = """
import sys

import omni.replicator.core as rep
{imports}

print(sys.argv[1:], sys.modules["__main__"].__file__ == __file__)
{end}
"""


@pytest.fixture(autouse=True)
def _session():
    session.restart()
    yield
    session.restart()


@pytest.mark.parametrize(("end", "code"), [("", 0), ("sys.exit(3)", 3), ("1 / 0", 1)])
def test_what_a_script_sees_as_its_own_ends_with_the_command(tmp_path, end, code):
    """Datasets that the process wrote later had a recipe and a journal, as if that script had written them."""
    (tmp_path / "beside.py").write_text("")
    (tmp_path / "script.py").write_text(SCRIPT.format(imports="import beside", end=end))
    before = sys.modules["__main__"], sys.argv, list(sys.path)
    done = CliRunner().invoke(app, ["run", "--device", "cpu", str(tmp_path / "script.py"), "given"])
    assert done.exit_code == code, done.output
    assert "['given'] True" in done.output
    assert sys.modules["__main__"] is before[0]
    assert (sys.argv, sys.path) == before[1:]
    session.restart()
    assert current().run.claim(str(tmp_path / "out")) is None
