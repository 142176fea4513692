"""The notebooks in examples/: they run, and what is kept of their outputs is small and free of errors."""

import base64
import re
from pathlib import Path

import pytest

from tests.sampled_cases import sampled

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
LARGEST = 100_000  # bytes of a picture


def outputs(notebook) -> list:
    return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]


def kinds(notebook) -> list[list[str]]:
    """The kinds of what each cell shows, but for warnings and progress, which machines differ in."""
    shown = []
    for cell in notebook.cells:
        if cell.cell_type == "code":
            results = [each for each in cell.outputs if each.output_type == "execute_result"]
            shown.append(sorted(name for each in results for name in each.data))
    return shown


def pictures(notebook) -> list[bytes]:
    texts = [each.get("data", {}) for each in outputs(notebook)]
    found = [data["image/png"] for data in texts if "image/png" in data]
    for data in texts:
        found += re.findall(r"data:image/png;base64,([^\"]+)", data.get("text/html", ""))
    return [base64.b64decode(each) for each in found]


def test_there_are_two():
    assert [path.stem for path in NOTEBOOKS] == ["first_scene", "look_at_a_dataset"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_kept_outputs_are_small_and_free_of_errors(path):
    notebook = nbformat.read(path, 4)
    nbformat.validate(notebook)
    assert {each.output_type for each in outputs(notebook)} <= {"execute_result", "display_data", "stream"}
    assert not [each for each in outputs(notebook) if each.get("name") == "stderr"]
    assert len(pictures(notebook)) >= 3
    assert max(map(len, pictures(notebook))) < LARGEST


@pytest.mark.parametrize("path", sampled(NOTEBOOKS), ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_what_it_has(path, tmp_path):
    notebook = nbformat.read(path, 4)
    before = kinds(notebook)
    # An error of any cell is raised here.
    nbclient.NotebookClient(
        notebook, timeout=200, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    # Both kinds of a picture are made; the file keeps the richest only.
    after = [[name for name in shown if "text/html" not in shown or name != "image/png"] for shown in kinds(notebook)]
    assert after == before
    assert len(pictures(notebook)) >= 3
