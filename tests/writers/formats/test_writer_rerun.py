"""RerunWriter and `--rerun`: what is logged, read back by Rerun's own reader."""

import io
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, UsdGeom

import usdsdg as rep
from tests import forked
from usdsdg import errors
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.semantics.labels import add_labels
from usdsdg.writers.formats.rerun.rrd_content import content

rr = pytest.importorskip("rerun.chunk")

SIZE, FRAMES = (96, 64), 3
VIEW = "/world/Replicator"


def read(file: Path) -> dict[tuple[str, str], dict]:
    """The values of a recording by (entity, component): {frame, or None for what is static: values}."""
    found: dict[tuple[str, str], dict] = {}
    for chunk in rr.RrdReader(file).stream().to_chunks():
        batch = chunk.to_record_batch()
        columns = dict(zip(batch.schema.names, batch.columns))
        for name, column in columns.items():
            if ":" in name:
                for row in range(batch.num_rows):
                    frame = None if chunk.is_static else columns["frame"][row].as_py()
                    values = column[row].values
                    found.setdefault((chunk.entity_path, name), {})[frame] = values.to_pylist()
    return found


def recorded(folder: Path, **options) -> tuple[dict, list[dict]]:
    """Record a moving crate and a ball in centimeters; return what is in the files, and what annotators had."""
    stage = rep.get_stage()
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    crate = rep.create.cube(position=(-100, 0, 0), scale=(1, 1, 0.5), semantics=[("class", "crate")])
    rep.create.sphere(position=(120, 0, 0), scale=0.6, semantics=[("class", "ball")])
    rep.create.light(light_type="Dome", intensity=1000)
    with rep.trigger.on_frame(), crate:
        rep.modify.pose(
            position=rep.distribution.uniform((-120, -50, -40), (-80, 50, 40), name="where"),
            rotation=rep.distribution.uniform((0, 0, 0), (30, 30, 90)),
        )
    product = rep.create.render_product(rep.create.camera(position=(30, -600, 80), look_at=(0, 0, 0)), SIZE)
    names = ("rgb", "distance_to_image_plane", "instance_segmentation", "bounding_box_2d_tight", "bounding_box_3d_360")
    seen = {name: rep.annotators.get(name).attach(product) for name in names}
    writer = rep.writers.get("RerunWriter")
    writer.initialize(output_dir=str(folder), **options)
    writer.attach(product)
    shown = []
    for _ in range(FRAMES):
        rep.orchestrator.step()
        shown.append({name: each.get_data() for name, each in seen.items()})
    rep.orchestrator.wait_until_complete()
    files = sorted(folder.glob("*.rrd"))
    assert [file.name for file in files] == [f"frame_{number:04}.rrd" for number in range(FRAMES)]
    found: dict = {}
    for file in files:
        for key, values in read(file).items():
            found.setdefault(key, {}).update(values)
    return found, shown


@pytest.fixture
def made(tmp_path, stage):
    return recorded(tmp_path)


def matrix(found: dict, path: str, frame: int) -> np.ndarray:
    """(4, 4) from an entity to the world, for column vectors, as Rerun defines its transforms."""
    to_world = np.eye(4)
    to_world[:3, :3] = np.reshape(found[path, "Transform3D:mat3x3"][frame][0], (3, 3)).T  # stored by columns
    to_world[:3, 3] = found[path, "Transform3D:translation"][frame][0]
    return to_world


def test_images_and_counts_are_those_of_the_annotators(made):
    found, shown = made
    for frame, seen in enumerate(shown):
        (blob,) = found[f"{VIEW}/rgb", "EncodedImage:blob"][frame]
        picture = np.asarray(Image.open(io.BytesIO(bytes(blob))))
        assert np.array_equal(picture, seen["rgb"][..., :3])
        (depth,) = found[f"{VIEW}/distance_to_image_plane", "DepthImage:buffer"][frame]
        depth = np.frombuffer(bytes(depth), np.float32).reshape(SIZE[::-1])
        assert np.array_equal(depth, seen["distance_to_image_plane"])
        assert found[f"{VIEW}/distance_to_image_plane", "DepthImage:meter"][frame] == [1.0]
        (mask,) = found[f"{VIEW}/instance_segmentation", "SegmentationImage:buffer"][frame]
        mask = np.frombuffer(bytes(mask), np.uint16).reshape(SIZE[::-1])
        assert np.array_equal(mask, seen["instance_segmentation"]["data"])
        boxes = seen["bounding_box_2d_tight"]["data"]
        halves = np.array(found[f"{VIEW}/bounding_box_2d_tight", "Boxes2D:half_sizes"][frame])
        assert np.array_equal(2 * halves[:, 0], boxes["x_max"] - boxes["x_min"] + 1)
        centers = np.array(found[f"{VIEW}/bounding_box_2d_tight", "Boxes2D:centers"][frame])
        assert np.array_equal(centers[:, 1] - halves[:, 1], boxes["y_min"])
        assert found[f"{VIEW}/bounding_box_2d_tight", "Boxes2D:labels"][frame] == ["crate", "ball"]
    objects = {path for path, name in found if name == "Boxes3D:half_sizes"}
    assert objects == {f"/world/objects{path}" for path in shown[0]["bounding_box_3d_360"]["info"]["primPaths"]}
    assert all(list(values) in ([None], list(range(FRAMES))) for values in found.values())


def test_corners_of_solids_project_to_the_edges_of_rectangles(made):
    """By Rerun's conventions alone: transforms to the parent, meters, a camera whose axes are right, up, back."""
    found, shown = made
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    right, up, back = 3, 1, 6  # Rerun's numbers of directions
    assert len(shown) == FRAMES
    for frame, seen in enumerate(shown):
        assert found[VIEW, "Pinhole:camera_xyz"][frame] == [[right, up, back]]
        assert found[VIEW, "Pinhole:resolution"][frame] == [list(SIZE)]
        lens = np.reshape(found[VIEW, "Pinhole:image_from_camera"][frame][0], (3, 3)).T
        box = seen["bounding_box_2d_tight"]["data"][0]  # the crate, which nothing occludes
        path = f"/world/objects{seen['bounding_box_2d_tight']['info']['primPaths'][0]}"
        (center,), (half,) = found[path, "Boxes3D:centers"][frame], found[path, "Boxes3D:half_sizes"][frame]
        local = np.array(center) + corners * half
        in_world = local @ matrix(found, path, frame)[:3, :3].T + matrix(found, path, frame)[:3, 3]
        assert 0.4 < np.ptp(in_world[:, 2]) < 2.0  # meters
        to_camera = np.linalg.inv(matrix(found, VIEW, frame))
        in_camera = in_world @ to_camera[:3, :3].T + to_camera[:3, 3]
        pixels = (in_camera * [1, -1, -1]) @ lens.T  # to right, down, forward
        pixels = pixels[:, :2] / pixels[:, 2:]
        edges = [box["x_min"], box["y_min"], box["x_max"] + 1, box["y_max"] + 1]
        assert np.allclose([*pixels.min(axis=0), *pixels.max(axis=0)], edges, atol=1.0)  # pixels are hit at centers


def test_objects_in_objects_are_where_they_are(stage, tmp_path):
    """Rerun multiplies the transforms of all entities that a path is below."""
    UsdGeom.SetStageMetersPerUnit(rep.get_stage(), 0.01)
    places = {}
    for path, place in (("/Car", (1, 2, 3)), ("/Car/Seats/Seat", (4, 0, 0)), ("/Car/Seats/Seat/Belt", (0, 5, 0))):
        prim = UsdGeom.Cube.Define(rep.get_stage(), path)
        add_labels(prim.GetPrim(), {"class": [path[-4:].strip("/").lower()]})
        prim.AddTranslateOp().Set(Gf.Vec3d(*place))
        prim.AddRotateZOp().Set(30.0)
        prim.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))
        places[path] = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(0))
    product = rep.create.render_product(rep.create.camera(position=(300, 0, 0), look_at=(0, 0, 0)), SIZE)
    writer = rep.writers.get("RerunWriter")
    writer.initialize(output_dir=str(tmp_path))
    writer.attach(product)
    rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    found = read(tmp_path / "frame_0000.rrd")
    for path, to_world in places.items():
        composed = np.eye(4)
        while path:
            if (f"/world/objects{path}", "Transform3D:mat3x3") in found:
                composed = matrix(found, f"/world/objects{path}", 0) @ composed
            path = path.rpartition("/")[0]
        expected = np.diag((0.01, 0.01, 0.01, 1.0)) @ to_world.T
        np.testing.assert_allclose(composed, expected, atol=1e-6)


def test_draws_are_scalars_over_frames_and_the_world_has_an_up_axis(made):
    found, shown = made
    draws = found["/draws/where", "Scalars:scalars"]
    for frame, seen in enumerate(shown):
        position = seen["bounding_box_3d_360"]["data"]["transform"][0][3, :3]
        assert np.allclose(draws[frame], position, atol=1e-3)  # of the prim, in its own units
    assert len({tuple(values) for values in draws.values()}) == FRAMES
    assert found["/world", "ViewCoordinates:xyz"][None] == [[3, 5, 1]]  # right, forward, up


def test_what_is_logged_repeats_with_its_ids(tmp_path):
    made = []
    for name in ("a", "b"):
        session.restart()
        rep.set_global_seed(5)
        new_stage()
        recorded(tmp_path / name)
        made.append([content(file) for file in sorted((tmp_path / name).glob("*.rrd"))])
    assert made[0] == made[1]
    assert made[0][0] != made[0][1]
    session.restart()


def test_objects_that_are_gone_leave_before_the_others_are_logged(tmp_path, stage):
    recorded(tmp_path)
    rows = {}
    for chunk in rr.RrdReader(tmp_path / "frame_0001.rrd").stream().to_chunks():
        batch = chunk.to_record_batch()
        rows[chunk.entity_path, batch.schema.names[-1].partition(":")[0]] = batch.column(0)[0].as_py()
    clear = rows.pop(("/world/objects", "Clear"))
    objects = [row for (path, _), row in rows.items() if path.startswith("/world/objects/")]
    assert len(objects) == 4
    assert all(clear < row for row in objects)


def test_pictures_of_other_lenses_are_logged_without_a_pinhole(tmp_path, stage):
    camera = rep.create.camera(position=(0, -5, 0), look_at=(0, 0, 0), projection_type="fisheyePolynomial")
    writer = rep.writers.get("RerunWriter")
    writer.initialize(output_dir=str(tmp_path))
    writer.attach(rep.create.render_product(camera, (16, 12)))
    with pytest.warns(errors.UsdsdgWarning, match="pinholes only"):  # from the thread that writes
        rep.orchestrator.run_until_complete(num_frames=1)
    found = read(tmp_path / "frame_0000.rrd")
    assert (VIEW, "Transform3D:translation") in found
    assert (VIEW, "Pinhole:resolution") not in found


def test_without_the_extra_one_line_says_what_to_install(tmp_path, stage, monkeypatch):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(errors.Unsupported, match=r"pip install 'usdsdg\[rerun\]'"):
        rep.writers.get("RerunWriter").initialize(output_dir=str(tmp_path))


SCRIPT = """
import os
import usdsdg as rep
rep.create.cube(semantics=[("class", "crate")])
writer = rep.writers.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("out"), rgb=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(0, -5, 0), look_at=(0, 0, 0)), (24, 16)))
rep.orchestrator.run(num_frames=3)
"""


def usdsdg(folder: Path, *arguments: str, expect: int = 0) -> str:
    done = forked.run(["-m", "usdsdg", *arguments], cwd=folder, timeout=120)
    assert done.returncode == expect, done.stderr
    return done.stderr


def test_a_job_is_recorded_in_a_file_beside_its_data(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    said = usdsdg(tmp_path, "run", "-q", "--device", "cpu", "--rerun", "run.rrd", "script.py")
    assert "rerun " in said
    found = read(tmp_path / "run.rrd")
    assert sorted(found[f"{VIEW}/rgb", "EncodedImage:blob"]) == [0, 1, 2]
    for frame in range(3):
        (blob,) = found[f"{VIEW}/rgb", "EncodedImage:blob"][frame]
        written = np.asarray(Image.open(tmp_path / "out" / f"rgb_{frame:04}.png"))
        assert np.array_equal(np.asarray(Image.open(io.BytesIO(bytes(blob)))), written[..., :3])
    assert [file.name for file in tmp_path.glob(".*.rrd")] == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rerun", "run.txt"], "a file that ends in .rrd"),
        (["--rerun", "run.rrd", "--workers", "2"], "cannot be given with --workers"),
    ],
)
def test_odd_options_are_one_line(tmp_path, arguments, words):
    (tmp_path / "script.py").write_text(SCRIPT)
    said = usdsdg(tmp_path, "run", "-q", *arguments, "script.py", expect=1)
    assert words in said
    assert "Traceback" not in said


def test_the_viewer_needs_a_display(monkeypatch):
    from usdsdg.writers.formats.rerun.recording import VIEWER, JobRecording

    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(errors.Unsupported, match="no display"):
        JobRecording(VIEWER)


def test_a_value_may_be_left_out(tmp_path, monkeypatch):
    from usdsdg.cli.options.optional_values import completed

    monkeypatch.chdir(tmp_path)
    for name in ("script.py", "job.yaml", "old.rrd"):
        (tmp_path / name).touch()
    assert completed(["run", "--rerun", "script.py"]) == ["run", "--rerun", "viewer", "script.py"]
    assert completed(["run", "--rerun", "old.rrd", "script.py"]) == ["run", "--rerun", "old.rrd", "script.py"]
    assert completed(["run", "script.py", "--rerun"]) == ["run", "script.py", "--rerun"]
    assert completed(["generate", "job.yaml", "--rerun"]) == ["generate", "job.yaml", "--rerun", "viewer"]
