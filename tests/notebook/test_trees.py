"""What notebooks show of stages, prims and the graph."""

import subprocess
import sys
import textwrap

from pxr import UsdGeom

import usdsdg as rep
from usdsdg.notebook import stages


def test_a_stage_is_a_tree_of_prims_with_types_and_labels(stage):
    cube = rep.create.cube(semantics=[("class", "crate"), ("color", "r<d")])
    html = stages.stage_html(rep.get_stage())
    name = cube.prims[0].rsplit("/", 1)[-1]
    assert html.index("World") < html.index(name)
    assert "class: crate; color: r&lt;d" in html
    assert "Z up, 1 m per unit" in html
    assert html.count("<details") == html.count("</details>")
    assert html.count("<div") == html.count("</div>")


def test_a_large_stage_is_cut_with_a_count(stage):
    for number in range(stages.CHILDREN + 5):
        UsdGeom.Xform.Define(stage, f"/World/part_{number}")
    html = stages.stage_html(stage)
    assert "and 5 more" in html
    assert f"part_{stages.CHILDREN - 1}<" in html
    assert f"part_{stages.CHILDREN}<" not in html


def test_a_prim_shows_its_attributes(stage):
    UsdGeom.Cube.Define(stage, "/World/cube").CreateSizeAttr(2.5)
    html = stages.prim_html(stage.GetPrimAtPath("/World/cube"))
    assert "size" in html
    assert "2.5" in html


def test_nodes_stand_under_their_triggers(stage):
    cube = rep.create.cube()
    with rep.trigger.on_frame(max_execs=4) as every, cube:
        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 2, 3)))
    with rep.trigger.on_time(interval=2), cube:
        rep.randomizer.color(colors=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
    rep.orchestrator.step()
    html = rep.get_graph()._repr_html_()
    first, second = (html.index(kind) for kind in ("on_frame", "on_time"))
    assert first < html.index("SampleUniform(lower=[0, 0, 0], upper=[1, 2, 3])") < second
    assert "of 4 times" in html
    assert html.index("test_trees.py:") < second
    assert "on_frame" in every._repr_html_()
    assert "on_time" not in every._repr_html_()
    assert cube.prims[0] in cube._repr_html_()


def test_a_trigger_that_fired_once_ran_one_time(stage):
    with rep.trigger.on_frame() as every, rep.create.cube():
        rep.modify.visibility(True)
    rep.orchestrator.step()
    assert "ran 1 time ·" in every._repr_html_()


def test_ipython_shows_stages_and_plain_python_does_not_load_it(tmp_path):
    script = """
        import sys
        import usdsdg
        assert not {"IPython", "PIL", "pxr", "usdsdg.notebook"} & sys.modules.keys()
        for name in [name for name in sys.modules if name.startswith("usdsdg")]:
            del sys.modules[name]
        from IPython.core.interactiveshell import InteractiveShell
        shell = InteractiveShell.instance()
        shell.display_formatter.active_types = ["text/plain", "text/html"]
        import usdsdg as rep
        assert "pxr" not in sys.modules
        rep.create.cube()
        for thing in (rep.get_stage(), rep.get_stage().GetPrimAtPath("/Replicator")):
            shown, _ = shell.display_formatter.format(thing)
            assert "Replicator" in shown["text/html"], shown
        print("shown")
    """
    (tmp_path / "script.py").write_text(textwrap.dedent(script))
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "shown", done.stderr
