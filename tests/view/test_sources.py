"""Scripts and jobs: the viewer stops at each frame, writers write nothing, and draws are those of a run."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests import forked
from tests.cli.datasets import content
from tests.view.pages import Page
from usdsdg.errors import ConfigError, GraphError
from usdsdg.session import devices, session
from usdsdg.session.stage_context import current_stage, save_stage
from usdsdg.view.jobs import of_job
from usdsdg.view.stages import of_stage
from usdsdg.view.viewer import Viewer

SCRIPT = """
import usdsdg as rep

box = rep.create.cube(position=(0, 0, 0.5), semantics=[("class", "box")])
camera = rep.create.camera(position=(0, -6, 2), look_at=(0, 0, 0.5))
with rep.trigger.on_frame(), box:
    rep.modify.pose(position=rep.distribution.uniform((-2, -2, 0), (2, 2, 1)))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="written", rgb=True)
writer.attach(rep.create.render_product(camera, (64, 48)))
for _ in range(3):
    rep.orchestrator.step()
"""


class Ended(Exception):
    """Ends a viewer, as Ctrl-C does."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    session.restart()
    devices.use_device("cpu")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.py").write_text(SCRIPT)
    yield tmp_path
    session.restart()


class Watching(Viewer):
    """A viewer whose page goes on as soon as it has seen a frame, and that ends after the last.

    wishes: what the page asks for at each frame before it goes on.
    """

    def __init__(self, *wishes: dict) -> None:
        super().__init__("script.py")
        self.page, self.wishes, self.frames = Page(self, 32, 24), wishes, []
        self._pictures = self._turns = 0
        self.places: list[tuple] = []  # of the box at each frame, as the script has left it

    def run(self, **options):
        self._pictures, self._turns = len(self.page.pictures), 0
        boxes = [each for each in current_stage().Traverse() if each.GetName().startswith("Cube_Xform")]
        self.places += [tuple(each.GetAttribute("xformOp:translate").Get()) for each in boxes]
        for wish in self.wishes:
            self.page.ask(**wish)
        super().run(**options)

    def _turn(self) -> None:
        super()._turn()
        self.page.receive()
        self._turns += 1
        if self._turns > 3 and len(self.page.pictures) > self._pictures:
            self._pictures = 1 << 30
            self.frames.append(self.page.values["state"]["frame"])
            if self.frames[-1] is None:
                raise Ended
            self.page.ask(do="next")


def watched(*wishes: dict, seed: int | None = None) -> Watching:
    """Show the script to its end, in a session of its own."""
    session.restart()
    devices.use_device("cpu")
    viewer = Watching(*wishes)
    with pytest.raises(Ended):
        of_job(Path("script.py"), [], seed)(viewer)
    return viewer


def test_the_viewer_stops_at_each_frame_and_nothing_is_written(folder):
    viewer = watched()
    assert viewer.frames == [0, 1, 2, None]
    assert not (folder / "written").exists()
    assert viewer.page.values["scene"]["cameras"][0]["size"] == [64, 48]
    assert viewer.page.errors == []


def test_a_dataset_of_the_script_stays_as_it_is_where_the_script_writes_a_file_by_its_writer(folder):
    script = SCRIPT.replace('"written"', 'os.path.abspath("written")').replace("import us", "import os\nimport us")
    (folder / "script.py").write_text(script + 'writer.backend.write_blob("notes.txt", b"cubes")\n')
    done = forked.run(["script.py"], cwd=folder)
    assert done.returncode == 0, done.stderr
    before = content(folder / "written")
    assert "notes.txt" in before
    assert watched().frames == [0, 1, 2, None]
    assert content(folder / "written") == before


def test_what_is_randomized_or_played_between_frames_does_not_change_the_draws_of_the_script(folder):
    undisturbed = watched(seed=3).places[:3]
    disturbed = watched({"do": "randomize", "seed": 99}, {"do": "step"}, seed=3)
    assert disturbed.places[:3] == undisturbed
    assert disturbed.page.errors == []
    assert watched(seed=4).places[:3] != undisturbed


def test_a_script_that_captures_nothing_is_shown_with_its_first_draws(folder):
    (folder / "script.py").write_text(SCRIPT.replace("range(3)", "range(0)"))
    viewer = watched()
    assert viewer.frames == [None]
    assert viewer.page.pictures[-1][1].std() > 5


def test_a_job_is_shown_frame_by_frame(folder):
    config = Path(__file__).parents[2] / "configs/detection.yaml"
    viewer = Watching()
    with pytest.raises(Ended):
        of_job(config, ["num_frames=2", "resolution=[64,48]"], None)(viewer)
    assert viewer.frames == [0, 1, None]
    assert not [*folder.rglob("*.jpg"), *folder.rglob("*.png")]


def test_ctrl_c_ends_a_job_that_waits_at_a_frame(folder):
    class Interrupted(Watching):
        def _turn(self) -> None:
            super()._turn()
            if self.page.pictures:
                signal.raise_signal(signal.SIGINT)

    config = Path(__file__).parents[2] / "configs/detection.yaml"
    viewer = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        of_job(config, ["num_frames=2", "resolution=[64,48]"], None)(viewer)
    assert viewer.frames in ([], [0])


def test_a_script_that_fails_ends_the_viewer_with_its_error(folder, capfd):
    (folder / "script.py").write_text("import usdsdg as rep\nrep.create.nothing()\n")
    with pytest.raises(GraphError):
        watched()
    assert "nothing" in capfd.readouterr().err


def test_a_file_that_is_nothing_to_view_is_an_error(folder):
    (folder / "notes.txt").write_text("x")
    with pytest.raises(ConfigError, match=r"notes\.txt"):
        of_job(Path("notes.txt"), [], None)


def test_a_graph_that_is_saved_in_a_stage_can_be_run(folder):
    watched()
    save_stage(folder / "saved.usda")
    session.restart()
    devices.use_device("cpu")
    viewer = Watching({"do": "randomize", "seed": 5})
    with pytest.raises(Ended):
        of_stage(folder / "saved.usda")(viewer)
    assert viewer.page.values["scene"]["triggers"] == ["on_frame"]
    assert viewer.page.values["state"]["seed"] == 5
    assert viewer.page.errors == []


def test_a_mesh_file_is_shown(folder):
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {face}" for face in faces)]
    (folder / "box.obj").write_text("\n".join(lines))
    viewer = Watching()
    with pytest.raises(Ended):
        of_stage(folder / "box.obj")(viewer)
    assert viewer.page.pictures[-1][1].std() > 5
