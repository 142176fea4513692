"""usdsdg as a library: scripts in a process of their own that only import usdsdg."""

import os
import shlex
import subprocess
import sys
import textwrap

import pytest

from tests import forked
from tests.sampled_cases import sampled
from usdsdg.verify.verify import verify

HEAD = """
import usdsdg as rep
from usdsdg.session.stage_context import current_stage, new_stage
"""
CAMERA = """
camera = rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0))
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=OUT, rgb=True)
writer.attach(rep.create.render_product(camera, (8, 8)))
"""


FUNCTION = """
import multiprocessing

def square(number):
    return number * number

"""
CALL = """
process = multiprocessing.get_context("spawn").Process(target=square, args=(2,))
process.start()
process.join()
print("exit code", process.exitcode)
"""


def python(folder, script: str, *, expect: int = 0, fresh: bool = False) -> subprocess.CompletedProcess[str]:
    """Run a script in `folder`; its variable `OUT` is a folder for files, `fresh` as in `forked.run`."""
    path = folder / "script.py"
    path.write_text(f"OUT = {str(folder / 'out')!r}\n{HEAD}\n{textwrap.dedent(script)}")
    environment = {name: value for name, value in os.environ.items() if name != "USDSDG_ASSETS_ROOT"}
    done = forked.run([str(path)], cwd=folder, timeout=120, env=environment, fresh=fresh)
    assert done.returncode == expect, f"{done.stdout}\n{done.stderr}"
    return done


def test_a_new_stage_resets_graph_products_writers_and_engines(tmp_path):
    script = """
        from usdsdg.session import engines
        from usdsdg.graph.evaluate import graph
        from usdsdg.create.render_products import products
        from usdsdg.writers.base import attached_writers
        old = engines.renderer()
        with rep.trigger.on_frame():
            rep.randomizer.rotation(input_prims=camera)
        new_stage()
        print(graph().triggers, products(), attached_writers(), engines.renderer() is old)
    """
    assert python(tmp_path, CAMERA + textwrap.dedent(script)).stdout.strip() == "[] [] () False"


def test_a_body_falls_while_the_timeline_plays(tmp_path):
    script = """
        from usdsdg.stage.poses.transforms import local_to_world
        ball = rep.create.sphere(position=(0, 0, 5))
        with ball:
            rep.physics.rigid_body()
        rep.orchestrator.set_capture_on_play(False)  # else the timeline is stopped at the end
        rep.orchestrator.run(num_frames=31, start_timeline=True)
        print(local_to_world(current_stage().GetPrimAtPath(ball.prims[0])).ExtractTranslation()[2])
    """
    # Half a second; half a step of travel is 0.04 m.
    assert abs(float(python(tmp_path, script).stdout) - (5 - 9.81 / 8)) < 0.05


def test_settings_of_output_folder_and_queue_take_effect(tmp_path):
    script = """
        from usdsdg.backends import io_queue
        rep.settings.carb_settings("/omni/replicator/backends/disk/root_dir", OUT)
        rep.settings.carb_settings("/omni/replicator/backend/queueSize", 7)
        writer = rep.writers.get("BasicWriter")
        writer.initialize(output_dir="below", rgb=True)
        print(writer.backend.output_dir, io_queue.max_jobs)
    """
    assert python(tmp_path, script).stdout.strip() == f"{tmp_path / 'out' / 'below'} 7"


def test_a_file_that_could_not_be_written_makes_the_program_exit_with_an_error(tmp_path):
    (tmp_path / "out" / "rgb_0000.png").mkdir(parents=True)
    script = """
        import atexit, time
        from usdsdg.stores import whole_file
        write = whole_file._write
        def write_late(part, chunks):  # when the script has ended: the step would raise an earlier failure itself
            time.sleep(2)
            write(part, chunks)
        whole_file._write = write_late
        atexit.register(print, "cleaned up")
        rep.orchestrator.step()
        print("script ended")
    """
    done = python(tmp_path, CAMERA + textwrap.dedent(script), expect=1)
    assert "error: " in done.stderr
    assert "rgb_0000.png" in done.stderr
    assert done.stdout.splitlines() == ["script ended", "cleaned up"]


def test_a_first_run_has_no_warning_and_ends_with_the_next_commands(tmp_path):
    # The kernels of so small a picture compile in seconds, which is a line or two.
    light = "rep.create.light(light_type='Dome')\n"
    done = python(tmp_path, light + CAMERA + "rep.orchestrator.run(num_frames=2)\n", fresh=True)
    lines = [line for line in done.stderr.splitlines() if "compiling" not in line]
    assert lines[0] == f"[usdsdg] BasicWriter writes to {tmp_path / 'out'}"
    assert lines[1].startswith("[usdsdg] frames captured: 2/2")
    assert [line.partition("   (")[0].rstrip() for line in lines[2:]] == [
        "[usdsdg] next: usdsdg inspect out",
        "[usdsdg]       usdsdg verify out",
    ]
    assert len(list((tmp_path / "out").glob("rgb_*.png"))) == 2


LIGHT = "rep.create.light(light_type='Dome')\n"
UNATTACHED = CAMERA.replace("writer.attach(", "(")


@pytest.mark.parametrize(
    ("script", "remark"),
    [
        (
            CAMERA,
            "BasicWriter is attached, but no frame was captured: nothing started a run. Call rep.orchestrator.run",
        ),
        (UNATTACHED + "rep.orchestrator.run(num_frames=2)\n", "BasicWriter was initialized, but not attached"),
        (CAMERA + "rep.orchestrator.step()\n", "the only picture is black"),
        (LIGHT + CAMERA.replace("rgb=True", "bounding_box_2d_tight=True") + "rep.orchestrator.step()\n", "no label"),
        (UNATTACHED, ""),
        (CAMERA + "new_stage()\nrep.orchestrator.step()\n", "BasicWriter was attached, and detached before the first"),
        (CAMERA + "raise SystemExit(0)\n", "BasicWriter is attached"),
        (CAMERA + FUNCTION + "if __name__ == '__main__':\n" + textwrap.indent(CALL, "    "), "BasicWriter is attached"),
    ],
    ids=[
        "no run",
        "not attached",
        "no light",
        "no label",
        "no run and not attached",
        "new stage",
        "sys.exit",
        "processes",
    ],
)
def test_a_program_that_leaves_nothing_to_see_ends_with_one_remark(tmp_path, script, remark):
    remarks = [line for line in python(tmp_path, script).stderr.splitlines() if "remark: " in line]
    assert [line.startswith(f"[usdsdg] remark: {remark}") for line in remarks] == [True] * bool(remark)


def test_a_program_that_fails_ends_with_its_error(tmp_path):
    assert "remark: " not in python(tmp_path, CAMERA + "raise KeyError('of the program')\n", expect=1).stderr


def test_a_run_that_its_triggers_end_before_its_frames_says_so(tmp_path):
    script = """
        with rep.trigger.on_frame(max_execs=2):
            rep.randomizer.rotation(input_prims=camera)
        rep.orchestrator.run(num_frames=5)
    """
    done = python(tmp_path, LIGHT + CAMERA + textwrap.dedent(script))
    assert "[usdsdg] frames captured: 2/2" in done.stderr
    assert "[usdsdg] the run ended 3 frames before the 5 of run(num_frames=5): all triggers" in done.stderr


def test_data_before_the_first_frame_are_empty_and_warned_of(tmp_path):
    script = """
        annotator = rep.annotators.get("distance_to_camera")
        annotator.attach(rep.create.render_product(camera, (8, 8)))
        print(annotator.get_data().size)
        rep.orchestrator.step()
        print(annotator.get_data().size)
    """
    done = python(tmp_path, LIGHT + CAMERA + textwrap.dedent(script))
    assert done.stdout.split() == ["0", "64"]
    assert done.stderr.count("annotator 'distance_to_camera' has no frame yet") == 1


def test_a_folder_is_named_once_whatever_the_number_of_stages(tmp_path):
    """As of bin picking, each drop of which has a stage of its own."""
    scene = "rep.create.light(light_type='Dome')\n" + CAMERA + "rep.orchestrator.step()\n"
    done = python(tmp_path, scene + "new_stage()\n" + scene)
    assert done.stderr.count("BasicWriter writes to") == 1


def test_a_program_is_silent_where_the_environment_or_a_setting_says_so(tmp_path, monkeypatch):
    quiet = "rep.settings.carb_settings('/usdsdg/progress', False)\n"
    scene = "rep.create.light(light_type='Dome')\n" + CAMERA + "rep.orchestrator.step()\n"
    assert python(tmp_path, quiet + scene).stderr == ""
    monkeypatch.setenv("USDSDG_PROGRESS", "0")
    (tmp_path / "another").mkdir()  # a second run in the first one's folder is a warning
    assert python(tmp_path / "another", scene).stderr == ""


def test_demo_assets_are_substituted_and_named_once(tmp_path):
    url = "/Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd"
    done = python(tmp_path, f"rep.create.from_usd({url!r})\nnew_stage()\nrep.create.from_usd({url!r})\n")
    (line,) = done.stderr.splitlines()
    assert line.startswith("[usdsdg] demo assets")
    assert "USDSDG_ASSETS_ROOT" in line
    assert "set_assets_root" in line


def test_importing_usdsdg_imports_no_engine_or_cli(tmp_path):
    script = """
        import sys
        print([name for name in ("warp", "newton", "usdsdg.demo", "click", "usdsdg.cli") if name in sys.modules])
    """
    assert python(tmp_path, script, fresh=True).stdout.strip() == "[]"


def test_processes_that_import_the_program_again_do_not_replace_its_frames(tmp_path):
    """Without a seed each process draws others; on macOS and Windows all processes are started so."""
    light = "rep.create.light(light_type='Dome')\n"
    done = python(tmp_path, light + CAMERA + "rep.orchestrator.run(num_frames=2)\n" + FUNCTION + CALL, fresh=True)
    assert done.stdout.splitlines()[-1] == "exit code 1"
    assert "DatasetInTheWay: multiprocessing has started this process" in done.stderr
    assert "if __name__ == '__main__':" in done.stderr
    assert not verify(tmp_path / "out").faults


def test_processes_that_import_a_guarded_program_run_its_functions(tmp_path):
    """A scene and a writer may be made at the top level, as long as nothing is captured there."""
    guard = "if __name__ == '__main__':\n"
    captured = textwrap.indent("rep.orchestrator.run(num_frames=2)\n" + CALL, "    ")
    light = "rep.create.light(light_type='Dome')\n"
    done = python(tmp_path, light + CAMERA + FUNCTION + guard + captured, fresh=True)
    assert done.stdout.splitlines()[-1] == "exit code 0"


@pytest.mark.parametrize("closed", sampled(["<&- >&- 2>&-", ">&- 2>&-", "2>&-"]))
def test_a_program_whose_standard_streams_are_closed_writes_its_files(tmp_path, closed):
    """As services and programs without a console have it: there is no `sys.stderr`, and 0 to 2 are free for files."""
    path = tmp_path / "script.py"
    light = "rep.create.light(light_type='Dome')\n"
    numbers = f"open({str(tmp_path / 'number')!r}, 'w').write(str(open(__file__).fileno()))\n"
    path.write_text(f"OUT = {str(tmp_path / 'out')!r}\n{HEAD}\n{numbers}{light}{CAMERA}rep.orchestrator.run(2)\n")
    command = f"exec {shlex.join([sys.executable, str(path)])} {closed}"
    assert subprocess.run(["sh", "-c", command], cwd=tmp_path, timeout=120, check=False).returncode == 0
    assert len(list((tmp_path / "out").glob("rgb_*.png"))) == 2
    assert int((tmp_path / "number").read_text()) > 2


@pytest.mark.parametrize("stream", ["None", "type('Lines', (), {'write': lambda self, text: len(text)})()"])
def test_a_program_may_replace_standard_error(tmp_path, stream):
    light = "rep.create.light(light_type='Dome')\n"
    replaced = f"import sys\nsys.stderr = {stream}\n"
    back = "sys.stderr = sys.__stderr__  # which Python flushes at its end\n"
    python(tmp_path, replaced + light + CAMERA + "rep.orchestrator.run(num_frames=2)\n" + back)
    assert len(list((tmp_path / "out").glob("rgb_*.png"))) == 2
