"""`usdsdg run --worlds N` writes the files of `usdsdg run`, whose frames it draws and traces together."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from usdsdg.capture.pictures_ahead import PicturesAhead
from usdsdg.cli.app import app
from usdsdg.session import session

SCRIPT = Path(__file__).parents[2] / "examples/scenes/moving_shapes.py"
FRAMES = 5


def files_of(folder, monkeypatch, *options):
    """Bytes of the files that the script writes, by name."""
    session.restart()
    folder.mkdir()
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *options, str(SCRIPT), str(FRAMES), "24"])
    session.restart()
    assert done.exit_code == 0, done.output
    written = [file for file in folder.rglob("*") if file.is_file() and file.suffix in (".png", ".npy", ".json")]
    return {str(file.relative_to(folder)): file.read_bytes() for file in written}


def test_the_files_are_the_same(tmp_path, monkeypatch):
    traced = []
    pictures = PicturesAhead.pictures

    def noted(self, frame):
        found = pictures(self, frame)
        traced.append((self.frame, frame, len(found)))
        return found

    one_by_one = files_of(tmp_path / "single", monkeypatch)
    monkeypatch.setattr(PicturesAhead, "pictures", noted)
    assert files_of(tmp_path / "together", monkeypatch, "--worlds", "3") == one_by_one
    assert sum(name.endswith(".png") for name in one_by_one) == FRAMES
    assert traced == [(0, 0, 1), (0, 1, 1), (0, 2, 1), (3, 3, 1), (3, 4, 1)]


SCATTERED = """
import omni.replicator.core as rep

floor = rep.create.plane(scale=4, rotation=(10, 0, 0))
cubes = rep.create.cube(count=4, scale=0.5, semantics=[("class", "cube")])
rep.create.group([cubes, floor])
rep.create.light(light_type="dome", intensity=500)
product = rep.create.render_product(rep.create.camera(position=(5, 0, 4), look_at=(0, 0, 0)), (24, 16))
with rep.trigger.on_frame(max_execs=4), cubes:
    rep.modify.pose(rotation=rep.distribution.uniform((0, 0, 0), (90, 90, 90)))
    rep.randomizer.scatter_2d(floor, check_for_collisions=True)
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="{folder}", rgb=True, bounding_box_3d=True)
writer.attach(product)
rep.orchestrator.run()
"""


def test_scattered_prims_are_drawn_together(tmp_path):
    found = []
    for name, options in (("single", []), ("together", ["--worlds", "4"])):
        session.restart()
        script = tmp_path / f"{name}.py"
        script.write_text(SCATTERED.format(folder=tmp_path / name))
        done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *options, str(script)])
        assert done.exit_code == 0, done.output
        assert "one by one" not in done.output
        found.append({file.name: file.read_bytes() for file in (tmp_path / name).glob("[rb]*_*.*")})
    session.restart()
    assert sum(name.startswith("rgb") for name in found[0]) == 4
    assert found[0] == found[1]


DRESSED = """
import omni.replicator.core as rep

with rep.new_layer():
    paints = rep.create.material_omnipbr(diffuse=rep.distribution.uniform((0, 0, 0), (1, 1, 1)), count=4)
    cube = rep.create.cube(scale=0.3, semantics=[("class", "cube")])
    rep.create.light(light_type="dome", intensity=500)
    product = rep.create.render_product(rep.create.camera(position=(5, 0, 4), look_at=(0, 0, 0)), (24, 16))
    with rep.trigger.on_frame(max_execs=3), cube:
        rep.randomizer.materials(paints)
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="{folder}", rgb=True)
writer.attach(product)
rep.orchestrator.run()
"""


def test_what_worlds_cannot_draw_is_rendered_one_by_one_with_a_warning(tmp_path):
    found = []
    for name, options in (("single", []), ("together", ["--worlds", "4"])):
        session.restart()
        script = tmp_path / f"{name}.py"
        script.write_text(DRESSED.format(folder=tmp_path / name))
        done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *options, str(script)])
        assert done.exit_code == 0, done.output
        found.append({file.name: file.read_bytes() for file in (tmp_path / name).glob("rgb*.png")})
    session.restart()
    assert len(found[0]) == 3
    assert found[0] == found[1]
    assert "OgnWriteMaterial" in done.output
    assert "Frames are rendered one by one" in done.output


LIMITED = """
import omni.replicator.core as rep

cube = rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome", intensity=500)
product = rep.create.render_product(rep.create.camera(position=(5, 0, 4), look_at=(0, 0, 0)), (24, 16))
with rep.trigger.on_frame(max_execs=4), cube:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
with rep.trigger.on_frame(max_execs=2, interval=2), cube:
    rep.randomizer.rotation()
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="{folder}", rgb=True, bounding_box_2d_tight=True)
writer.attach(product)
rep.orchestrator.run_until_complete({frames})
"""


@pytest.mark.parametrize(("frames", "expected"), [("num_frames=9", 4), ("num_frames=2", 2), ("", 4)])
def test_runs_end_with_their_triggers(tmp_path, frames, expected):
    found = []
    for name, options in (("single", []), ("together", ["--worlds", "3"])):
        session.restart()
        script = tmp_path / f"{name}.py"
        script.write_text(LIMITED.format(folder=tmp_path / name, frames=frames))
        done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *options, str(script)])
        assert done.exit_code == 0, done.output
        found.append({file.name: file.read_bytes() for file in (tmp_path / name).glob("[rb]*_*.*")})
    session.restart()
    assert sum(name.startswith("rgb") for name in found[0]) == expected
    assert found[0] == found[1]


SOME_PICTURES = """
import omni.replicator.core as rep

cube = rep.create.cube(semantics=[("class", "cube")])
rep.create.light(light_type="dome", intensity=500)
product = rep.create.render_product(rep.create.camera(position=(5, 0, 4), look_at=(0, 0, 0)), (24, 16))
with rep.trigger.on_frame(), cube:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
for name, options in {{"rgb": {{"trigger": rep.trigger.on_frame(interval=2)}}, "bounding_box_2d_tight": {{}}}}.items():
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir="{folder}/" + name, **{{name: True}})
    writer.attach(product, **options)
rep.orchestrator.run(num_frames=4)
"""


def test_records_of_frames_without_a_picture_have_none(tmp_path):
    """Those of frames that were traced together with others had one, so that `reproduce` found them different."""
    found = []
    for name, options in (("single", []), ("together", ["--worlds", "2"])):
        session.restart()
        script = tmp_path / name / "script.py"  # whose name is in the stage that is recorded
        script.parent.mkdir()
        script.write_text(SOME_PICTURES.format(folder=tmp_path / name))
        done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *options, str(script)])
        assert done.exit_code == 0, done.output
        records = (tmp_path / name / "bounding_box_2d_tight").rglob("*.npz")
        found.append({file.name: file.read_bytes() for file in records})
    session.restart()
    assert len(found[0]) == 4
    assert found[0] == found[1]


BELOW = """
import usdsdg as rep
from pxr import Sdf

cubes = rep.create.cube(count=2, position=(0, 1, 0), semantics=[("class", "cube")])
rep.create.light(light_type="dome", intensity=500)
product = rep.create.render_product(rep.create.camera(position=(9, 0, 2), look_at=(0, 0, 0)), (24, 16))
below = Sdf.Layer.CreateAnonymous(".usda")
rep.get_stage().GetRootLayer().subLayerPaths.append(below.identifier)
rep.get_stage().SetEditTarget(below)
with rep.trigger.on_frame({options}):
    rep.modify.pose(position=rep.distribution.uniform((0, -2, -1), (0, 2, 1)), input_prims=cubes)
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir="{folder}", rgb=True)
writer.attach(product)
rep.orchestrator.run(num_frames=4)
"""


@pytest.mark.parametrize("options", ["", "interval=3"])
def test_records_have_what_is_written_below_another_layer(options, tmp_path):
    found = []
    for name, given in (("single", []), ("together", ["--worlds", "2"])):
        session.restart()
        script = tmp_path / name / "script.py"  # whose name is in the stage that is recorded
        script.parent.mkdir()
        script.write_text(BELOW.format(folder=tmp_path / name / "out", options=options))
        done = CliRunner().invoke(app, ["run", "-q", "--device", "cpu", *given, str(script)])
        assert done.exit_code == 0, done.output
        files = [*(tmp_path / name / "out").glob("rgb*.png"), *(tmp_path / name / "out/.usdsdg/frames").iterdir()]
        found.append({file.name: file.read_bytes() for file in files})
    session.restart()
    assert len(found[0]) == 8
    assert found[0] == found[1]
