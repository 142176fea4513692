"""Where no folder of temporary files can be written to, what needs one says how to name one."""

import tempfile

import pytest

from usdsdg.errors import OutputNotWritable
from usdsdg.stores.mirror import Mirror
from usdsdg.stores.temporary import temporary_root
from usdsdg.workers.local import make_parts
from usdsdg.workers.plan import Part


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """As on a full disk: Python tries folders, and can make a file in none of them."""
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(tempfile, "_candidate_tempdir_list", lambda: [str(tmp_path / "gone")])
    monkeypatch.chdir(tmp_path)


def test_it_is_the_folder_that_python_takes(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert temporary_root() == str(tmp_path)


@pytest.mark.parametrize(
    "use",
    [
        temporary_root,
        lambda: make_parts(lambda part: ["true"], [Part(0, 1)], 1, lambda: None),
        lambda: Mirror(None, "", lambda name: True, lambda name: False),  # type: ignore[arg-type] - not come to
    ],
)
def test_without_one_the_error_names_what_was_tried_and_the_remedy(use, nowhere):
    with pytest.raises(OutputNotWritable, match=r"gone.*export TMPDIR=FOLDER"):
        use()
