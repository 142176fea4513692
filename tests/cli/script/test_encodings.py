"""Scripts are read as Python reads them, in whatever encoding they say."""

import pytest

from usdsdg.cli.script.execution import _program
from usdsdg.compat.coverage.used_names import _parsed


@pytest.mark.parametrize(
    "source",
    [
        b"\xef\xbb\xbfname = 'gr\xc3\xbcn'\n",
        b"# -*- coding: latin-1 -*-\nname = 'gr\xfcn'\n",
        b"name = 'gr\xc3\xbcn'\r\n",
    ],
)
def test_a_script_runs_in_its_encoding(tmp_path, source):
    """A mark of the byte order, as editors of Windows write it, was an invalid character."""
    script = tmp_path / "script.py"
    script.write_bytes(source)
    names = {}
    exec(_program(script, names), names)
    assert names["name"] == "grün"
    assert _parsed(script).body


def test_bytes_that_are_no_text_are_a_syntax_error_as_in_python(tmp_path):
    script = tmp_path / "script.py"
    script.write_bytes(b'name = "\xff"\n')
    with pytest.raises(SyntaxError):
        _program(script, {})
