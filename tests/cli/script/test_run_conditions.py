"""`usdsdg run` with what an author had in the GUI: an open stage, its light, a press on Start, assets elsewhere."""

import json
import subprocess
import textwrap

import pytest
from PIL import Image

from tests.scripts.conftest import usdsdg

# As in the Script Editor: a writer and a trigger on the open stage, and no run.
EDITOR = """
    import omni.usd
    import omni.replicator.core as rep
    stage = omni.usd.get_context().get_stage()
    units = 1.0 if stage.GetMetadata("upAxis") == "Z" else 100.0
    camera = rep.create.camera(position=(4 * units, 3 * units, 5 * units), look_at=(0, 0, 0))
    cube = rep.create.cube(semantics=[("class", "cube")])
    with rep.trigger.on_frame():
        with cube:
            rep.modify.pose(rotation=rep.distribution.uniform((0, 0, 0), (360, 360, 360)))
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir="OUTPUT", rgb=True, bounding_box_2d_tight=True)
    writer.attach([rep.create.render_product(camera, (32, 32))])
"""


def run(folder, script: str, *options: str, expect: int = 0) -> subprocess.CompletedProcess[str]:
    text = textwrap.dedent(script).replace("OUTPUT", str(folder / "out"))
    (folder / "script.py").write_text(text)
    return usdsdg("run", "--quiet", "--device", "cpu", *options, "script.py", cwd=folder, expect=expect)


def test_a_script_that_starts_no_run_ends_with_a_remark(tmp_path):
    done = run(tmp_path, EDITOR)
    assert "remark: BasicWriter is attached, but no frame was captured" in done.stderr
    assert "--frames N" in done.stderr
    assert not list((tmp_path / "out").glob("rgb*"))


@pytest.mark.parametrize("kind", ["kit", "isaac"])
def test_start_captures_frames_0_to_n_in_the_light_of_a_new_stage(tmp_path, kind):
    done = run(tmp_path, EDITOR, "--new-stage", kind, "--frames", "2")
    assert "remark" not in done.stderr
    assert [file.name for file in sorted((tmp_path / "out").glob("rgb_*"))] == [f"rgb_000{i}.png" for i in range(3)]
    with Image.open(tmp_path / "out" / "rgb_0002.png") as image:
        assert image.convert("L").getextrema()[1] > 100
    labels = json.loads((tmp_path / "out" / "bounding_box_2d_tight_labels_0002.json").read_text())
    assert labels == {"0": {"class": "cube"}}


def test_steps_at_which_nothing_was_attached_are_told(tmp_path):
    (tmp_path / "script.py").write_text(
        "import omni.replicator.core as rep\n"
        "rep.create.render_product(rep.create.camera(), (8, 8))\n"
        "with rep.trigger.on_frame():\n"
        "    with rep.create.cube():\n"
        "        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))\n"
        "rep.orchestrator.step()\n"
        "rep.orchestrator.step()\n"
    )
    done = usdsdg("run", "script.py", cwd=tmp_path)
    assert "at all 2 steps no annotator or writer was attached" in done.stderr
    assert "Start" not in done.stderr


def test_a_writer_that_waits_for_its_schedule_is_told_as_such(tmp_path):
    (tmp_path / "script.py").write_text(
        "import omni.replicator.core as rep\n"
        "product = rep.create.render_product(rep.create.camera(), (8, 8))\n"
        "writer = rep.writers.get('BasicWriter', init_params={'output_dir': 'out', 'rgb': True})\n"
        "writer.attach(product, trigger=None)\n"
        "rep.orchestrator.step()\n"
    )
    done = usdsdg("run", "script.py", cwd=tmp_path)
    assert "BasicWriter is attached, but no frame was captured: a writer that is attached with trigger=None" in (
        " ".join(done.stderr.split())
    )
    assert "schedule_write()" in done.stderr


def test_a_script_without_a_render_product_is_not_sent_to_press_start(tmp_path):
    (tmp_path / "script.py").write_text(
        "import omni.replicator.core as rep\n"
        "with rep.trigger.on_frame():\n"
        "    with rep.create.cube():\n"
        "        rep.modify.pose(position=rep.distribution.uniform((0, 0, 0), (1, 1, 1)))\n"
    )
    done = usdsdg("run", "--frames", "2", "script.py", cwd=tmp_path)
    assert "no render product, so there is nothing to capture" in done.stderr
    assert "Start" not in done.stderr


def test_black_pictures_without_labels_end_with_remarks(tmp_path):
    script = EDITOR.replace('semantics=[("class", "cube")]', "")
    done = run(tmp_path, script, "--frames", "1")
    assert "remark: all 2 pictures are black" in done.stderr
    assert "remark: no label is in view in all 2 pictures" in done.stderr


def test_a_run_that_goes_on_is_not_judged_by_its_last_pictures(tmp_path):
    script = """
        import omni.replicator.core as rep
        cube = rep.create.cube(semantics=[("class", "cube")])
        rep.create.light(light_type="Dome")
        view = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
        # Motion vectors, for which the last frame is rendered again: another one may follow.
        options = {"output_dir": "OUTPUT", "motion_vectors": True, "bounding_box_2d_tight": True}
        rep.writers.get("BasicWriter", options, view)
        for visible in (True, False):
            with cube:
                rep.modify.visibility(visible)
            rep.orchestrator.step(delta_time=0.0)
    """
    for options in ((), ("--resume",)):
        done = run(tmp_path, script, *options)
        assert done.returncode == 0, done.stderr
        assert "remark: no label" not in done.stderr


def test_a_script_finds_the_stage_that_was_opened_and_its_mapped_references(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "cube.usda").write_text('#usda 1.0\n( defaultPrim = "C" )\ndef Cube "C" {}\n')
    (tmp_path / "scene.usda").write_text(
        '#usda 1.0\n( upAxis = "Y" )\ndef "Set" {\ndef "Cube" ( references = @omniverse://host/P/cube.usda@ ) {}\n}\n'
    )
    script = """
        from isaacsim import SimulationApp
        app = SimulationApp({"headless": True})
        import carb.settings, omni.usd
        stage = omni.usd.get_context().get_stage()
        more = stage.DefinePrim("/More")
        more.GetReferences().AddReference("omniverse://host/P/cube.usda", "/C")
        print([str(p.GetPath()) for p in stage.Traverse() if p.GetTypeName() == "Cube"])
        print(carb.settings.get_settings().get("/usdsdg/replicator/version"))
        app.close()
    """
    options = ("--stage", "scene.usda", "--map", "omniverse://host/P=mine", "--replicator", "4")
    done = run(tmp_path, script, *options)
    assert done.stdout.splitlines() == ["['/Set/Cube', '/More']", "4"]


MISSING = """
    import omni.usd
    import omni.replicator.core as rep
    print("started")
    for name in ("a", "b"):
        rep.create.from_usd(f"omniverse://host/P/{name}.usd")
    prim = omni.usd.get_context().get_stage().DefinePrim("/World/C")
    prim.GetReferences().AddReference("/no/such/" + "c.usd")
    rep.orchestrator.step()
    print("captured")
"""


def test_missing_assets_are_listed_at_the_first_frame(tmp_path):
    done = run(tmp_path, MISSING, expect=1)
    assert done.stdout == "started\n"
    assert "error: 3 assets are missing:" in done.stderr
    for name, line in (("omniverse://host/P/a.usd", 6), ("omniverse://host/P/b.usd", 6), ("/no/such/c.usd", 8)):
        assert f"{name} (script.py:{line})" in done.stderr


def test_missing_assets_that_are_caught_or_left_alone_fail_at_the_end(tmp_path):
    script = MISSING.replace("rep.orchestrator.step()", "pass")
    done = run(tmp_path, script, "--lenient", expect=1)
    assert done.stdout == "started\ncaptured\n"
    assert "error: 3 assets are missing:" in done.stderr


def test_without_missing_assets_the_script_goes_on(tmp_path):
    done = run(tmp_path, MISSING, "--missing-assets", "skip")
    assert done.stdout == "started\ncaptured\n"
    assert done.stderr.count("is left out, since it is missing") == 3


def test_assets_that_the_text_names_are_looked_up_before_the_script_starts(tmp_path):
    script = """
        print("started")
        import omni.replicator.core as rep
        rep.create.from_usd("omniverse://host/P/a.usd")
        rep.create.from_usd("C:/b.usd")
    """
    done = run(tmp_path, script, expect=1)
    assert done.stdout == ""
    assert "error: 2 assets are missing:" in done.stderr
    assert "C:/b.usd (script.py:5)" in done.stderr


SWALLOWS = """
    import omni.replicator.core as rep
    try:
        writer = rep.WriterRegistry.get("BasicWriter")
        writer.initialize(output_dir="/proc/nothing", rgb=True)
    except Exception as error:
        print("failed")
"""


@pytest.mark.parametrize(("options", "code"), [((), 1), (("--lenient",), 0)])
def test_an_error_of_a_writer_that_the_script_catches_is_said_at_the_end(tmp_path, options, code):
    done = run(tmp_path, SWALLOWS, *options, expect=code)
    assert done.stdout == "failed\n"
    assert ("error: the script caught an error" in done.stderr) == bool(code)
    if code:
        assert "script.py:5: OutputNotWritable: /proc/nothing" in done.stderr


def test_an_error_of_the_scripts_own_writer_that_it_catches_is_said_too(tmp_path):
    script = """
        import omni.replicator.core as rep
        class Mine(rep.Writer):
            def __init__(self):
                self.annotators = ["rgb"]
            def write(self, data):
                raise KeyError("rgb_left")
        rep.WriterRegistry.register(Mine)
        writer = rep.WriterRegistry.get("Mine")
        writer.initialize()
        writer.attach(rep.create.render_product(rep.create.camera(), (8, 8)))
        try:
            rep.orchestrator.step()
        except Exception:
            print("went on")
    """
    done = run(tmp_path, script, expect=1)
    assert done.stdout == "went on\n"
    assert "the script caught an error and went on" in done.stderr
    assert "KeyError: 'rgb_left'" in done.stderr


def test_an_error_shows_the_text_of_the_line(tmp_path):
    script = """
        import omni.replicator.core as rep
        name = "PoseWritter"
        rep.WriterRegistry.get(name)
    """
    done = run(tmp_path, script, expect=1)
    assert "script.py:4: in <module>" in done.stderr
    assert "    rep.WriterRegistry.get(name)" in done.stderr


def test_frames_end_a_run_that_nothing_ends(tmp_path):
    endless = EDITOR + "    rep.orchestrator.run()\n"
    done = run(tmp_path, endless, expect=1)
    assert "nothing ends the run" in done.stderr
    assert "--frames N" in done.stderr
    run(tmp_path, endless, "--frames", "2")
    assert len(list((tmp_path / "out").glob("rgb*"))) == 3


def test_arguments_of_kit_are_settings_in_scripts_without_an_application(tmp_path):
    (tmp_path / "script.py").write_text("import carb\nprint(carb.settings.get_settings().get('/my/setting'))\n")
    assert usdsdg("run", "script.py", "--/my/setting=5", cwd=tmp_path).stdout.split() == ["5"]


def test_a_writer_that_fails_leaves_the_datasets_of_others_whole(tmp_path):
    """The script catches the error of its own writer, at the first frame and at the last one."""
    script = """
        import contextlib
        import omni.replicator.core as rep

        class Broken(rep.Writer):
            def __init__(self):
                self.annotators = ["rgb"]

            def write(self, data):
                raise RuntimeError("broken")

        rep.WriterRegistry.register(Broken)
        product = rep.create.render_product(rep.create.camera(position=(5, 5, 5), look_at=(0, 0, 0)), (8, 8))
        broken, basic = rep.WriterRegistry.get("Broken"), rep.WriterRegistry.get("BasicWriter")
        broken.initialize()
        basic.initialize(output_dir="OUTPUT", rgb=True)
        for writer in (broken, basic, basic, broken):
            writer.attach(product)
            with contextlib.suppress(RuntimeError):
                rep.orchestrator.step()
            writer.detach()
    """
    run(tmp_path, script, "--lenient")
    done = usdsdg("verify", "out", cwd=tmp_path)
    assert "0 faults" in done.stdout
    assert "images: 2" in done.stdout
