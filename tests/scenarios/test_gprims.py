"""Rows of gprims by the prim that they are at or below, against USD's own paths."""

from pxr import Sdf

from usdsdg.scenarios.gprims import rows_below

GPRIMS = ("/World/a", "/World/a/b", "/World/ab/c", "/World/many[0]", "/World/many[12]/leaf", "/World/x/many[1][2]")
OWNERS = ["/World/a", "/World/ab", "/World/many", "/World", "/World/none", "/World/x/many"]


def test_rows_are_those_whose_path_has_the_prim_as_a_prefix(stage):
    prims = [stage.DefinePrim(path, "Xform") for path in OWNERS]
    expected = [
        [row for row, path in enumerate(GPRIMS) if Sdf.Path(path.split("[", 1)[0]).HasPrefix(prim.GetPath())]
        for prim in prims
    ]
    assert rows_below(GPRIMS, prims) == expected
    assert expected[0] == [0, 1]
