"""Boxes of point instancers that have themselves among their prototypes, at which USD ends the process."""

import subprocess
import sys

import pytest

STAGE = """#usda 1.0
def Xform "World" {
    def Cube "Cube" {
    }
    def PointInstancer "First" {
        point3f[] positions = [(0, 0, 0)]
        int[] protoIndices = [0]
        rel prototypes = %s
    }
    def PointInstancer "Second" {
        point3f[] positions = [(5, 0, 0)]
        int[] protoIndices = [0]
        rel prototypes = %s
    }
}
"""
PROGRAM = """
import sys
from pxr import Usd
from usdsdg.stage.geometry.drawn_box import DrawnBoxes
stage = Usd.Stage.Open(sys.argv[1])
for name in ("First", "Second"):
    box = DrawnBoxes(Usd.TimeCode.Default()).in_world(stage.GetPrimAtPath(f"/World/{name}"))
    print(None if box is None else box.tolist())
"""
CUBE_AT_5 = "[[4.0, -1.0, -1.0], [6.0, 1.0, 1.0]]"


@pytest.mark.parametrize(
    ("first", "second", "boxes"),
    [
        ("</World/First>", "</World/Cube>", ["None", CUBE_AT_5]),  # itself
        ("</World>", "</World/Cube>", ["None", CUBE_AT_5]),  # what it is in
        ("</World/Second>", "</World/First>", ["None", "None"]),  # each other
        ("</World/Second>", "</World/Second>", ["None", "None"]),  # one that has itself
        ("</World/Second>", "</World/Cube>", [CUBE_AT_5, CUBE_AT_5]),  # no circle: boxes are nested
    ],
)
def test_the_box_of_one_that_draws_itself_is_none(first, second, boxes, tmp_path):
    (tmp_path / "stage.usda").write_text(STAGE % (first, second))
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "stage.usda")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == boxes
