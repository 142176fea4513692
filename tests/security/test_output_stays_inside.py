"""Nothing that a file says, which is no program, is written outside of the output folder."""

import os
import textwrap

import pytest

import usdsdg as rep
from usdsdg.errors import OutputNotWritable, UsdsdgError
from usdsdg.replicator_yaml import run_file
from usdsdg.scenarios import saved_pipeline
from usdsdg.scenarios.saved_pipeline import Overrides
from usdsdg.session.confinement import confined
from usdsdg.session.stage_context import snapshot
from usdsdg.stage import flatten

# Writers that another test of the process has attached write too.
pytestmark = pytest.mark.usefixtures("stage")

GRAPH = """
    camera: {{create.camera: {{position: [0, 0, 5], look_at: [0, 0, 0]}}}}
    cube: {{create.cube: {{semantics: [[class, cube]]}}}}
    product: {{create.render_product: {{camera: camera, resolution: [16, 16]}}}}
    writer: {{writers.get: {{name: {writer}}}}}
    set: {{writer.initialize: {{output_dir: {output}, {options}}}}}
    attach: {{writer.attach: {{render_products: product}}}}
    trigger: {{trigger.on_frame: {{num_frames: 1}}}}
"""


@pytest.fixture
def root(tmp_path):
    """The folder of relative output folders, to which files that are no programs are confined."""
    (tmp_path / "root").mkdir()
    rep.settings.get_settings().set("/omni/replicator/backends/disk/root_dir", str(tmp_path / "root"))
    with confined(tmp_path / "root"):
        yield tmp_path / "root"
    rep.settings.get_settings().set("/omni/replicator/backends/disk/root_dir", "")


def graph(tmp_path, output, writer="BasicWriter", options="rgb: true"):
    file = tmp_path / "graph.yaml"
    file.write_text(textwrap.dedent(GRAPH.format(output=output, writer=writer, options=options)))
    return file


def files(folder):
    return {path.relative_to(folder).as_posix().split("/")[0] for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("output", ["{tmp}/elsewhere", "../elsewhere", "a/../../elsewhere", "~/elsewhere", "link/a"])
def test_a_graph_in_yaml_names_no_folder_elsewhere(root, tmp_path, output):
    (tmp_path / "far").mkdir()
    os.symlink(tmp_path / "far", root / "link")
    with pytest.raises(UsdsdgError, match="--allow-outside"):
        run_file(graph(tmp_path, output.format(tmp=tmp_path)))
    assert files(tmp_path) == {"graph.yaml"}


@pytest.mark.parametrize("output", ["s3://bucket/a", "gs://bucket/a", "az://container/a"])
def test_a_graph_in_yaml_names_no_bucket(root, tmp_path, output):
    with pytest.raises(UsdsdgError, match="--allow-outside"):
        run_file(graph(tmp_path, output))


def test_a_graph_in_yaml_writes_below_the_root(root, tmp_path):
    run_file(graph(tmp_path, "set/one"))
    rep.orchestrator.wait_until_complete()
    assert any((root / "set/one").glob("rgb*.png"))


def test_names_that_a_graph_gives_stay_inside(root, tmp_path):
    options = "rgb: true, dataset_id: ../../../up/ID"
    with pytest.raises(UsdsdgError, match="no slashes"):
        write(graph(tmp_path, "coco", "CocoWriter", options))
    assert not (tmp_path / "up").exists()


def write(file):
    run_file(file)
    rep.orchestrator.wait_until_complete()


def saved(tmp_path, output, settings=None):
    """Return a stage that was saved with its graph."""
    camera = rep.create.camera(position=(0, 0, 5), look_at=(0, 0, 0))
    rep.create.cube(semantics=[("class", "cube")])
    for key, value in (settings or {}).items():
        rep.settings.get_settings().set(key, value)
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(output), rgb=True)
    writer.attach(rep.create.render_product(camera, (16, 16)))
    with rep.trigger.on_frame(num_frames=1):
        pass
    rep.orchestrator.step()
    flatten.write_layer(snapshot(tmp_path), tmp_path / "saved.usda")
    writer.detach()
    return tmp_path / "saved.usda"


def test_a_saved_stage_names_no_folder_elsewhere(tmp_path):
    file = saved(tmp_path, tmp_path / "first")
    with pytest.raises(OutputNotWritable, match="--allow-outside"):
        saved_pipeline.run(file, Overrides(num_frames=1))
    saved_pipeline.run(file, Overrides(num_frames=1), allow_outside=True)
    saved_pipeline.run(file, Overrides(num_frames=1, output_dir=str(tmp_path / "given")))
    assert any((tmp_path / "given").glob("rgb*.png"))


def test_a_program_names_any_folder(tmp_path):
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path / "any"), rgb=True)
    assert writer.backend.output_dir == str(tmp_path / "any")
