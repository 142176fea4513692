"""Which files a page may replace."""

import os
import stat

import pytest

from usdsdg.errors import OutputNotWritable
from usdsdg.inspect.report import _write


@pytest.mark.parametrize("name", ["job.yaml", "picture.png", "page"])
def test_a_file_that_is_no_page_is_not_replaced(tmp_path, name):
    (tmp_path / name).write_text("kept")
    with pytest.raises(OutputNotWritable, match=r"exists and is no \.html"):
        _write(tmp_path / name, "page")
    assert (tmp_path / name).read_text() == "kept"


def test_a_device_is_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputNotWritable, match=r"exists and is no \.html"):
        _write(tmp_path / "pipe", "page")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_an_earlier_page_is_replaced(tmp_path):
    for name in ("inspect.html", "other.HTM", "new"):
        for text in ("one", "two")[: 1 if name == "new" else 2]:
            _write(tmp_path / name, text)
            assert (tmp_path / name).read_text() == text
