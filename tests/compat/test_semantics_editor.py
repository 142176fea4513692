"""`semantics.schema.editor` reads and writes the labels that annotators read."""

import subprocess
import sys

import pytest

from usdsdg.compat.semantics.schema import editor
from usdsdg.errors import ArgumentError
from usdsdg.stage.semantics.labels import get_labels


@pytest.fixture
def prim(stage):
    return stage.DefinePrim("/World/mug", "Cube")


def test_entries_are_added_beside_others(prim):
    data = editor.PrimSemanticData(prim)
    data.add_entry("class", "mug, cup")
    data.add_entry("class", "blue")
    assert get_labels(prim) == {"class": ["mug", "cup", "blue"]} == data.get_entries()


def test_entries_of_one_type_are_removed(prim):
    data = editor.PrimSemanticData(prim)
    data.add_entry("class", "mug")
    data.add_entry("color", "blue")
    data.remove_entry("class")
    assert get_labels(prim) == {"color": ["blue"]}
    with pytest.raises(ArgumentError, match="class"):
        data.remove_entry("class")
    data.clear()
    assert get_labels(prim) == {}


def test_an_empty_entry_is_refused(prim):
    with pytest.raises(ArgumentError, match="needs a type and a label"):
        editor.PrimSemanticData(prim).add_entry("class")


@pytest.mark.parametrize(("kind", "expected"), [("NEW", ["mug", "cup"]), ("OVERWRITE", ["cup"]), ("SKIP", ["mug"])])
def test_what_happens_to_labels_that_are_there_is_chosen(prim, kind, expected):
    editor.add_semantics(prim, "class", "mug")
    text = editor.add_prim_semantics([prim], "cup", write_type=editor.LabelWriteType[kind])
    assert get_labels(prim) == {"class": expected}
    assert "/World/mug" in text


def test_a_preview_writes_nothing(prim):
    assert editor.add_prim_semantics(prim, {"class": "cup"}, preview=True).startswith("[PREVIEW]")
    assert get_labels(prim) == {}


def test_a_module_of_the_script_with_the_same_name_comes_first(tmp_path):
    (tmp_path / "semantics.py").write_text("mine = 1\n", encoding="utf-8")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
        "import usdsdg.compat; usdsdg.compat.install()\n"
        "import semantics; print(semantics.mine)\n"
        "import video_encoding; print(video_encoding.__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["1", "usdsdg.compat.video_encoding"], done.stderr
