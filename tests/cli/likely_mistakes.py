"""The most likely mistakes of a first day, and what is said of each.

`python -m tests.cli.likely_mistakes` writes docs/mistakes.md from them; a test makes every one and compares the page.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from click.testing import CliRunner

import usdsdg as rep
from usdsdg.errors import forget_warnings
from usdsdg.scenarios.jobs import load_job
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage
from usdsdg.stage import assets

PAGE = Path(__file__).resolve().parents[2] / "docs" / "mistakes.md"
HEAD = """# Likely mistakes, and what is said of them

Each was made as it is written here, in a folder with a `scene.usda` (a cube), a `script.py`, an `empty` folder and the
`detection.yaml` of `usdsdg new detection`; a test makes them again and compares this page. Messages name what is wrong,
where, and what to do. Commands print them without a traceback and end with an exit code other than 0; in Python they
are exceptions below `rep.errors.UsdsdgError`, or Python's own where a function is called wrongly.
"""


@dataclass(frozen=True)
class Mistake:
    """One mistake.

    kind: "command" (arguments of `usdsdg`), "configuration" (lines of a file) or "script" (lines after `import`).
    remedy: what the message must have to be of help.
    """

    kind: str
    text: str
    remedy: str


MISTAKES = [
    Mistake("command", "generat detection.yaml", "Did you mean 'generate'"),
    Mistake("command", "script.py", "`usdsdg run script.py`"),
    Mistake("command", "generate", "Missing argument"),
    Mistake("command", "generate detecton.yaml", "did you mean detection.yaml?"),
    Mistake("command", "generate detection.yaml --set num_frame=3", "did you mean num_frames"),
    Mistake("command", "generate detection.yaml --set num_frames", "key=value"),
    Mistake("command", "generate detection.yaml --set resolution=[320, 240]", "Quote what has blanks"),
    Mistake("command", "generate detection.yaml --sett seed=3", "--set"),
    Mistake("command", "generate detection.yaml --num_frames 3", "--set num_frames"),
    Mistake("command", "generate detection.yaml num_frames=3", "--set num_frames=3"),
    Mistake("command", "generate detection.yaml --output out", "--set output_dir="),
    Mistake("command", "generate detection.yaml -o out", "--set output_dir="),
    Mistake("command", "generate --config detection.yaml", "usdsdg generate job.yaml"),
    Mistake("command", "--seed 3 generate detection.yaml", "usdsdg generate --seed ..."),
    Mistake("command", "generate detection.yaml --seed three", "is not a valid whole number"),
    Mistake("command", "generate detection.yaml --frames 3", "--set num_frames=3"),
    Mistake("command", "generate detection.yaml --set resolution=640x480", "as in [320, 240]"),
    Mistake("command", "generate detection.yaml --set formats=coco", "{yolo: {}, coco: {}}"),
    Mistake("command", "generate detection.yaml --shard 4/4", "0/4"),
    Mistake("command", "generate script.py", "usdsdg run"),
    Mistake("command", "generate detection.yaml --device gpu", "Devices here: cpu"),
    Mistake("command", "run scene.usda", "usdsdg render"),
    Mistake("command", "run scrip.py", "script.py"),
    Mistake("command", "render scene.usd out", "scene.usda"),
    Mistake("command", "render scene.usda out --camera /World/Camera", "rep.create.camera"),
    Mistake("command", "render scene.usda out --resolution 640x480", "--width and --height"),
    Mistake("command", "render scene.usda picture.png", "give that of a folder, such as picture"),
    Mistake("command", "inspect empty", "give the folder"),
    Mistake("command", "verify empty", "give the folder"),
    Mistake("command", "verify _out_detecton", "give the folder"),
    Mistake("command", "convert mug.obj mug.usd", "give its path"),
    Mistake("command", "convert empty mug.usd", "is a folder"),
    Mistake("command", "compat scrip.py", "script.py"),
    Mistake("command", "new detection", "give another PATH"),
    Mistake("command", "help", "'--help'"),
    Mistake("configuration", "job: detection\nnum_frmaes: 10", "did you mean num_frames"),
    Mistake("configuration", "job: detection\nnum_frames: '10'", "is not a whole number"),
    Mistake("configuration", "job: detection\nobjects: {size_in_image: [0.7, 0.2]}", "the smaller number first"),
    Mistake("configuration", "job: detection\nformats: {yollo: {}}", "yolo"),
    Mistake("configuration", "job: detection\nformats: {yolo: {taks: segment}}", "Did you mean 'task'"),
    Mistake("configuration", "meshes: parts", "`job: detection`"),
    Mistake("configuration", "job: detectoin", "did you mean detection?"),
    Mistake("configuration", "job: detection\nnum_frames 10", "a colon and a space"),
    Mistake("configuration", "job: detection\nobjects: {per_image: [1, 1000000]}", "at most 10,000"),
    Mistake("configuration", "job: detection\n\tnum_frames: 10", "indent with spaces"),
    Mistake("configuration", "job: detection\nmeshes: part", "part"),
    Mistake("configuration", "writer_type: PoseWritr", "Did you mean 'PoseWriter'"),
    Mistake("script", "rep.creat", "did you mean create?"),
    Mistake("script", "rep.render_product", "rep.create.render_product"),
    Mistake("script", "rep.modify.scale", "rep.modify.pose(scale=...)"),
    Mistake("script", "rep.randomizer.my_lights()", "rep.randomizer.register(my_lights)"),
    Mistake("script", 'rep.create.light(type="dome")', "did you mean 'light_type'"),
    Mistake("script", "rep.create.camera(pos=(0, 0, 1))", "did you mean 'position'"),
    Mistake("script", "rep.create.from_usd(None)", "the path or URL of a file"),
    Mistake("script", 'rep.get.prims(path_pattern="*/Light")', "'.*/Light'"),
    Mistake("script", "rep.create.render_product(None, (640, 480))", "rep.create.camera makes one"),
    Mistake("script", "rep.create.cube(positon=(0, 0, 1))", "did you mean 'position'"),
    Mistake("script", "rep.create.cube(position=(0, 0))", "expected three numbers"),
    Mistake("script", 'rep.create.cube(visible="no")', "visible"),
    Mistake("script", 'rep.create.cube(semantics="cube")', "[('class', 'cube')]"),
    Mistake("script", 'rep.create.light(light_type="Doom")', "dome"),
    Mistake("script", 'rep.create.from_usd("mug.usd")', "USDSDG_ASSETS_ROOT"),
    Mistake("script", "rep.create.camera(position=(0, 0, 1), look_at=(0, 0, 1))", "move it or the target"),
    Mistake("script", 'rep.create.render_product("/World/Camera", (640, 480))', "rep.create.camera"),
    Mistake("script", "rep.create.render_product(rep.create.camera(), (640, 0))", "expected 1 to 16384"),
    Mistake("script", "rep.modify.pose(position=(0, 0, 1))", "inside `with"),
    Mistake("script", "rep.modify.visibility(False)", "inside `with"),
    Mistake("script", "rep.distribution.choice([])", "give at least one"),
    Mistake("script", 'rep.create.cube(semantics=[("class", "")])', "non-empty"),
    Mistake("script", "rep.modify.material(None)", "give at least one material"),
    Mistake("script", 'rep.writers.get("BasicWritr")', "Did you mean 'BasicWriter'"),
    Mistake("script", 'rep.writers.get("BasicWriter").initialize(output_dir="out", rgbb=True)', "Did you mean 'rgb'"),
    Mistake("script", 'rep.writers.get("BasicWriter").initialize(rgb=True)', "output_dir"),
    Mistake(
        "script",
        'rep.writers.get("BasicWriter").initialize(output_dir="out", depth=True)',
        "Did you mean 'distance_to_image_plane'",
    ),
    Mistake("script", 'rep.annotators.get("bounding_box_2d")', "bounding_box_2d_tight"),
    Mistake("script", 'rep.annotators.get("depth")', "distance_to_camera"),
    Mistake("script", 'rep.annotators.get("rgb").get_data()', "attach"),
    Mistake("script", "rep.preview()", "create or open something"),
    Mistake("script", "rep.orchestrator.run()", "num_frames"),
]


def said(mistake: Mistake, folder: Path) -> str:
    """Make a mistake in a folder of its own, and return what is said, with that folder left out."""
    _fill(folder)
    with _there(folder):
        if mistake.kind == "command":
            text = _of_command(mistake.text)
        elif mistake.kind == "configuration":
            (folder / "job.yaml").write_text(mistake.text)
            text = _of(lambda: load_job("job.yaml"))
        else:
            new_stage()
            text = _of(lambda: exec(compile(mistake.text, "script.py", "exec"), {"rep": rep}))
    for path in {str(folder), os.path.realpath(folder)}:
        text = text.replace(f"{path}{os.sep}", "").replace(path, "here")
    return re.sub(r"Devices here: .*", "Devices here: cpu.", text).strip()  # of a machine without GPU


def _fill(folder: Path) -> None:
    from usdsdg.cli.commands.new import Kind, write_starting_point

    (folder / "scene.usda").write_text('#usda 1.0\n(\n    upAxis = "Z"\n)\n\ndef Cube "Cube"\n{\n}\n')
    (folder / "script.py").write_text("import usdsdg as rep\n")
    (folder / "empty").mkdir()
    write_starting_point(Kind.DETECTION, folder / "detection.yaml")


@contextlib.contextmanager
def _there(folder: Path) -> Iterator[None]:
    """Work in a folder without an assets root, and undo what commands do to the process."""
    before, hooks = Path.cwd(), (warnings.showwarning, sys.unraisablehook)
    environment = os.environ.pop(assets.ROOT_VARIABLE, None)
    os.chdir(folder)
    session.restart()  # one before may have installed foreign names, with which stages have the viewport's cameras
    forget_warnings()
    try:
        yield
    finally:
        os.chdir(before)
        warnings.showwarning, sys.unraisablehook = hooks
        if environment is not None:
            os.environ[assets.ROOT_VARIABLE] = environment


def _of_command(arguments: str) -> str:
    from usdsdg.cli.app import app

    done = CliRunner().invoke(app, arguments.split())
    assert done.exit_code not in (0, None), f"usdsdg {arguments} ended with {done.exit_code}:\n{done.output}"
    return _plain(done.output)


def _plain(text: str) -> str:
    """Return a text without the lines on how a command is used, and those of progress."""
    lines = [line.strip() for line in text.splitlines()]
    return "\n".join(line for line in lines if line and not line.startswith(("Usage:", "Try ", "[usdsdg]")))


def _of(call) -> str:
    try:
        call()
    except Exception as error:  # noqa: BLE001 - whatever it is, it is what is said
        return f"{type(error).__name__}: {error}"
    raise AssertionError("nothing was said")


def page(texts: dict[Mistake, str]) -> str:
    """Return the page that shows mistakes with what is said of each."""
    parts = [HEAD]
    titles = {
        "command": "## On the command line",
        "configuration": "## In configurations",
        "script": "## In scripts",
    }
    languages = {"command": "text", "configuration": "yaml", "script": "text"}  # no Python that other tests run
    for kind, title in titles.items():
        parts.append(title + "\n")
        for mistake, text in texts.items():
            if mistake.kind == kind:
                source = f"usdsdg {mistake.text}" if kind == "command" else mistake.text
                source = source.replace("\t", "→")
                parts.append(f"```{languages[kind]}\n{source}\n```\n\n```text\n{text}\n```\n")
    return "\n".join(parts)


def main() -> None:
    """Write the page."""
    texts = {}
    for mistake in MISTAKES:
        with tempfile.TemporaryDirectory() as folder:
            texts[mistake] = said(mistake, Path(folder))
    PAGE.write_text(page(texts), encoding="utf-8")


if __name__ == "__main__":
    main()
