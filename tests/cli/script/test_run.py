"""`usdsdg run` from a shell: arguments, exit codes, Ctrl-C, and scripts that run their own event loop."""

import json
import signal
import subprocess
import sys
import textwrap

import pytest

from tests.scripts.conftest import usdsdg
from tests.signaled import run_and_signal


def run(folder, script: str, *arguments: str, expect: int = 0) -> subprocess.CompletedProcess[str]:
    (folder / "script.py").write_text(textwrap.dedent(script))
    return usdsdg("run", "--quiet", "script.py", *arguments, cwd=folder, expect=expect)


def test_arguments_after_the_script_belong_to_the_script(tmp_path):
    done = run(tmp_path, "import sys; print(sys.argv)", "--seed", "9", "-q", "--num", "2", "--help")
    assert done.stdout.strip() == "['script.py', '--seed', '9', '-q', '--num', '2', '--help']"
    assert done.stderr.splitlines() == [
        "remark: --seed is passed to script.py, which does not mention it. Options of usdsdg come before the script: "
        "usdsdg run --seed ... script.py"
    ]


def test_resume_after_the_script_is_refused_before_it_removes_frames(tmp_path):
    done = run(tmp_path, "print('began')", "--resume", expect=1)
    assert done.stdout == ""
    assert "Give it before the script: usdsdg run --resume script.py. After a -- it is the script's own." in done.stderr
    assert run(tmp_path, "print('began')", "--", "--resume").stdout == "began\n"


def test_a_script_may_leave_the_working_folder(tmp_path):
    script = """
    import os
    import omni.replicator.core as rep
    os.makedirs("deep")
    os.chdir("deep")
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=os.path.abspath("out"), rgb=True)
    rep.create.light(light_type="Dome")
    writer.attach(rep.create.render_product(rep.create.camera(), (16, 16)))
    rep.orchestrator.step()
    """
    run(tmp_path, script)
    assert (tmp_path / "deep/out/rgb_0000.png").is_file()
    assert (tmp_path / "deep/out/.usdsdg/source/script.py").is_file()
    again = usdsdg("reproduce", "--quiet", "out", cwd=tmp_path / "deep")
    assert again.stdout.strip().endswith("files equal, 0 different")
    assert "out: 0 files" not in again.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="Windows keeps the folder that a program is in")
def test_a_script_may_remove_the_folder_that_it_has_gone_to(tmp_path):
    script = """
    import os, sys
    import omni.replicator.core as rep
    os.makedirs("gone")
    os.chdir("gone")
    os.rmdir(os.getcwd())
    rep.create.light(light_type="Dome")
    with rep.create.cube():
        rep.randomizer.color(colors=[(1, 0, 0)])  # a material, whose file is not one of the working folder
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=sys.argv[1], rgb=True)
    writer.attach(rep.create.render_product(rep.create.camera(), (16, 16)))
    rep.orchestrator.step()
    """
    run(tmp_path, script, str(tmp_path / "out"))
    verified = usdsdg("verify", "--quiet", "out", cwd=tmp_path)
    assert "0 faults" in verified.stdout


def test_options_that_the_script_has_or_that_follow_two_dashes_are_its_own(tmp_path):
    assert run(tmp_path, "import sys; print('--seed' in sys.argv)", "--seed", "9", "--", "--frames=3").stderr == ""


def test_assets_root_and_save_stage_may_follow_the_script(tmp_path):
    (tmp_path / "assets").mkdir()
    text = "import sys; from usdsdg.stage import assets; print(sys.argv[1:], assets.assets_root())"
    done = run(
        tmp_path, text, "--num", "2", "--assets-root", "assets", "--save-stage=last.usda", "--", "--save-stage=x"
    )
    assert done.stdout.splitlines()[0] == f"['--num', '2', '--save-stage=x'] {tmp_path / 'assets'}"
    assert (tmp_path / "last.usda").is_file()
    assert not (tmp_path / "x").exists()


def test_an_unknown_option_before_the_script_is_named(tmp_path):
    done = usdsdg("run", "--sed", "9", "script.py", cwd=tmp_path, expect=2)
    assert "--sed" in done.stderr
    assert "--seed" in done.stderr


@pytest.mark.parametrize(
    ("argument", "code", "stderr"),
    [("", 0, ""), ("0", 0, ""), ("3", 3, ""), ("'bad things'", 1, "bad things\n"), ("[1]", 1, "[1]\n")],
)
def test_sys_exit_gives_the_exit_code_and_message_of_python(tmp_path, argument, code, stderr):
    done = run(tmp_path, f"import sys; sys.exit({argument})", expect=code)
    assert done.stderr == stderr


def test_sys_exit_in_a_task_prints_nothing(tmp_path):
    script = """
        import asyncio, sys
        async def main():
            await asyncio.sleep(0.01)
            sys.exit(3)
        asyncio.ensure_future(main())
    """
    assert run(tmp_path, script, expect=3).stderr == ""


def test_a_syntax_error_is_shown_as_python_does(tmp_path):
    done = run(tmp_path, "x = 1\ndef f(:\n", expect=1)
    assert done.stderr.splitlines()[0].strip() == 'File "script.py", line 2'
    assert done.stderr.splitlines()[-1] == "SyntaxError: invalid syntax"


def test_errors_are_shown_with_pythons_suggestions_and_causes(tmp_path):
    script = """
        import omni.replicator.core as rep
        def make():
            try:
                rep.create.cub()
            except AttributeError as error:
                raise ValueError("no cube") from error
        make()
    """
    lines = run(tmp_path, script, expect=1).stderr.splitlines()
    why = "AttributeError: module 'usdsdg.create' has no attribute 'cub'; did you mean cube?"
    assert any(line.startswith(why) for line in lines)
    assert "The above exception was the direct cause of the following exception:" in lines
    assert lines[-1] == "ValueError: no cube"
    assert all(line.startswith('  File "script.py", line ') for line in lines if line.startswith("  File "))


def test_annotations_of_a_script_are_what_python_makes_of_them(tmp_path):
    text = "def weigh(mass: float) -> int: ...\nprint(weigh.__annotations__)\n"
    (tmp_path / "script.py").write_text(text)
    assert usdsdg("run", "script.py", cwd=tmp_path).stdout == "{'mass': <class 'float'>, 'return': <class 'int'>}\n"
    (tmp_path / "script.py").write_text("from __future__ import annotations\n" + text)
    assert usdsdg("run", "script.py", cwd=tmp_path).stdout == "{'mass': 'float', 'return': 'int'}\n"


def test_a_script_may_await_at_its_top_level(tmp_path):
    (tmp_path / "script.py").write_text(
        "import omni.kit.app\n"
        "import omni.replicator.core as rep\n"
        "await omni.kit.app.get_app().next_update_async()\n"
        "cube = rep.create.cube(semantics=[('class', 'cube')])\n"
        "boxes = rep.annotators.get('bounding_box_2d_tight')\n"
        "boxes.attach(rep.create.render_product(rep.create.camera(position=(0, -5, 0), look_at=cube), (32, 32)))\n"
        "await rep.orchestrator.step_async()\n"
        "print(len(boxes.get_data()['data']))\n"
    )
    assert usdsdg("run", "script.py", cwd=tmp_path).stdout == "1\n"
    done = run(tmp_path, "import asyncio\nawait asyncio.sleep(0)\nraise ValueError('here')\n", expect=1)
    assert 'script.py", line 3' in done.stderr
    assert "ValueError: here" in done.stderr


def test_a_script_of_the_editor_has_omni_and_carb_without_an_import(tmp_path):
    done = run(
        tmp_path,
        "from pxr import UsdGeom\n"
        "async def main():\n"
        "    UsdGeom.Cube.Define(omni.usd.get_context().get_stage(), '/World/Box')\n"
        "    await omni.kit.app.get_app().next_update_async()\n"
        "    carb.log_warn('seen')\n"
        "await main()\n",
    )
    assert "seen" in done.stderr
    run(tmp_path, "print(omnia)\n", expect=1)


def test_a_script_is_the_main_module(tmp_path):
    script = """
        import pickle
        import __main__
        def double(x):
            return 2 * x
        if __name__ == "__main__":
            print(pickle.loads(pickle.dumps(double))(4), __main__.double is double, __file__)
    """
    assert run(tmp_path, script).stdout.strip() == "8 True script.py"


STANDALONE = """
    from isaacsim import SimulationApp
    simulation_app = SimulationApp({"headless": True})
    import asyncio
    import omni.kit.app
    import omni.replicator.core as rep

    async def main(name):
        await omni.kit.app.get_app().next_update_async()
        await rep.orchestrator.step_async()
        return name

    task = asyncio.ensure_future(main("loop"))
    while not task.done():
        simulation_app.update()
    print(task.result())
    print(asyncio.get_event_loop().run_until_complete(main("until complete")))
    print(simulation_app.run_coroutine(main("app")))
    print(asyncio.run(main("run")))
    simulation_app.close()
    while simulation_app.is_running():
        simulation_app.update()
"""


def test_a_standalone_script_may_run_coroutines_in_every_way_of_isaac_sim(tmp_path):
    assert run(tmp_path, STANDALONE).stdout.split("\n")[:4] == ["loop", "until complete", "app", "run"]


def test_a_standalone_script_runs_in_plain_python_too(tmp_path):
    script = "import usdsdg.compat; usdsdg.compat.install()\n" + textwrap.dedent(STANDALONE)
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.stdout.split("\n")[:4] == ["loop", "until complete", "app", "run"], done.stderr


SYNCHRONOUS = """
    import omni.replicator.core as rep

    camera = rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0))
    rep.create.cube()
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir="OUT", rgb=True)
    writer.attach(rep.create.render_product(camera, (16, 16)))
    rep.orchestrator.step()
    print("ready", flush=True)
    rep.orchestrator.run(num_frames=1_000_000)
"""
UPDATES = """
    import omni.kit.app
    app = omni.kit.app.get_app()
    print("ready", flush=True)
    while app.is_running():
        app.update()
"""
TASK = """
    import asyncio
    import omni.kit.app
    async def main():
        print("ready", flush=True)
        while True:
            await omni.kit.app.get_app().next_update_async()
    asyncio.ensure_future(main())
"""
IDLE = """
    import asyncio
    async def main():
        print("ready", flush=True)
        await asyncio.get_running_loop().create_future()
    asyncio.ensure_future(main())
"""
DELETIONS = """
    print("ready", flush=True)
    class Slow:
        def __del__(self):
            for _ in range(20_000):
                pass
    while True:
        Slow()
        for _ in range(20_000):
            pass
"""
# CPython marks a KeyboardInterrupt that leaves `exec` of source code as unhandled, until it executes other source code.
SOURCE = """
    import traceback
    import omni.replicator.core as rep

    rep.orchestrator.run(num_frames=1)
    print("ready", flush=True)
    exec("while True: pass")
"""


@pytest.mark.parametrize("script", [SYNCHRONOUS, UPDATES, TASK, IDLE, DELETIONS, SOURCE])
def test_ctrl_c_ends_a_script_and_leaves_no_partial_files(tmp_path, script):
    out = tmp_path / "out"
    returned, stderr = run_and_signal(tmp_path, script.replace("OUT", str(out)), signal.SIGINT)
    assert returned == 130, stderr
    assert "interrupted" in stderr
    assert "Traceback" not in stderr
    if script is SYNCHRONOUS:
        assert list(out.glob("rgb_*.png"))
        assert not list(out.glob(".*.part"))


COCO = """
    import omni.replicator.core as rep

    camera = rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0))
    rep.create.cube(semantics=[("class", "cube")])
    writer = rep.writers.get("CocoWriter")
    writer.initialize(output_dir="OUT", plain_names=True)
    writer.attach(rep.create.render_product(camera, (16, 16)))
    for _ in range(3):
        rep.orchestrator.step()
    print("ready", flush=True)
    rep.orchestrator.run(num_frames=1_000_000)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_of_a_scheduler_leaves_a_whole_dataset(tmp_path, number):
    out = tmp_path / "out"
    returned, stderr = run_and_signal(tmp_path, COCO.replace("OUT", str(out)), number)
    assert returned == 128 + number, stderr
    assert f"{number.name}: finishing the files in hand" in stderr
    assert stderr.splitlines()[-1] == "files written so far are whole; the same command with --resume goes on"
    data = json.loads((out / "annotations/instances_train.json").read_text())
    assert len(data["images"]) >= 3
    listed, there = {image["file_name"] for image in data["images"]}, {path.name for path in out.glob("train/*")}
    assert listed <= there
    assert len(there - listed) <= 1  # of the frame that was interrupted


FAILING = """
    import omni.replicator.core as rep
    from usdsdg.errors import WriterError

    class Closing(rep.Writer):
        def __init__(self):
            self.annotators, self.frames = ["rgb"], 0
        def write(self, data):
            self.frames += 1
        def on_final_frame(self):
            print(f"closed after {self.frames} frames", flush=True)

    class Failing(Closing):
        def write(self, data):
            super().write(data)
            if self.frames == 2:
                raise ERROR("no more")

    product = rep.create.render_product(rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0)), (16, 16))
    for writer in (Failing(), Closing()):
        writer.attach(product)
    rep.orchestrator.run(num_frames=5)
"""


@pytest.mark.parametrize(("error", "told"), [("WriterError", "error: no more"), ("ValueError", "ValueError: no more")])
def test_all_writers_are_told_of_the_end_of_a_run_that_fails(tmp_path, error, told):
    done = run(tmp_path, FAILING.replace("ERROR", error), expect=1)
    assert told in done.stderr
    assert done.stdout.splitlines() == ["closed after 2 frames", "closed after 2 frames"]


def test_what_fails_at_the_end_of_a_run_that_failed_is_told_as_well(tmp_path):
    script = FAILING.replace("ERROR", "WriterError").replace(
        'print(f"closed after {self.frames} frames", flush=True)', 'raise RuntimeError("not closed")'
    )
    done = run(tmp_path, script, expect=1)
    lines = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert [line.split(" (")[0] for line in lines] == [
        "error: no more",
        "error: at the end of the run: RuntimeError: not closed",
    ]


def test_a_run_that_cannot_end_is_refused_before_it_writes_files(tmp_path):
    script = SYNCHRONOUS.replace("OUT", str(tmp_path / "out")).split("rep.orchestrator.step()")[0] + (
        "rep.orchestrator.set_capture_on_play(False)\n"
        "    with rep.trigger.on_time(interval=1, num=3, enable_capture_on_play=False):\n"
        "        rep.randomizer.rotation(input_prims=camera)\n"
        "    rep.orchestrator.run()\n"
    )
    done = run(tmp_path, script, expect=1)
    assert "start_timeline=True" in done.stderr
    assert not list((tmp_path / "out").glob("rgb_*"))


@pytest.mark.parametrize(("option", "made"), [(("--shard", "1/2"), 3), (("--frames", "0:3"), 3), ((), 7)])
def test_progress_counts_the_frames_of_this_process(tmp_path, option, made):
    script = """
        import omni.replicator.core as rep

        writer = rep.writers.get("BasicWriter")
        writer.initialize(output_dir="OUT", semantic_segmentation=True)
        writer.attach(rep.create.render_product(rep.create.camera(position=(3, 0, 0)), (16, 16)))
        rep.orchestrator.run_until_complete(num_frames=7)
    """
    (tmp_path / "script.py").write_text(textwrap.dedent(script).replace("OUT", str(tmp_path / "out")))
    done = usdsdg("run", *option, "script.py", cwd=tmp_path)
    (*_, last) = (line for line in done.stderr.splitlines() if "frames captured" in line)
    assert f"frames captured: {made}/{made}" in last
