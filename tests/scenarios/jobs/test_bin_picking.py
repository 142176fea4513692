"""The bin picking job: its documented command, drops, rigs, and what the poses say."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from pxr import Gf

from tests.demo_assets import share_demo_assets
from tests.sampled_cases import in_soak, sampled
from tests.scenarios.jobs.own_meshes import write_three
from tests.scenarios.jobs.page import documented
from tests.scenarios.jobs.test_detection import digests, usdsdg
from usdsdg.cli.app import app
from usdsdg.cli.commands.generate import make_part
from usdsdg.errors import ConfigError
from usdsdg.scenarios.bin_picking import job
from usdsdg.scenarios.bin_picking.bin import given, suiting
from usdsdg.scenarios.bin_picking.cameras import add_cameras
from usdsdg.scenarios.bin_picking.drop import middle_of
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.jobs import load_job
from usdsdg.scenarios.shared.mesh_folder import files_by_label, read_assets
from usdsdg.scenarios.shared.runs import begin
from usdsdg.stage.cameras.camera_view import read_camera

CONFIG = Path(__file__).parents[3] / "configs" / "bin_picking.yaml"
SMALL = [
    "drops=2", "frames_per_drop=2", "parts.per_bin=[4,6]", "parts.collider=convexHull", "cameras.count=2",
    "cameras.calibration=lens.yaml", "cameras.undistorted=true", "rendering.samples=4",
    "splits={train_pbr: 1, val_pbr: 1}",
]  # fmt: skip
LENS = {
    "image_width": 160, "image_height": 120, "camera_name": "wrist", "distortion_model": "plumb_bob",
    "camera_matrix": {"rows": 3, "cols": 3, "data": [150.0, 0.0, 80.5, 0.0, 152.0, 58.0, 0.0, 0.0, 1.0]},
    "distortion_coefficients": {"rows": 1, "cols": 5, "data": [-0.2, 0.05, 0.001, 0.0, 0.0]},
}  # fmt: skip


def generate(folder: Path) -> Path:
    write_three(folder / "parts")
    (folder / "lens.yaml").write_text(yaml.safe_dump(LENS))
    overrides = [each for item in SMALL for each in ("--set", item)]
    usdsdg(*documented("configs/bin_picking.yaml", "parts"), *overrides, cwd=folder)
    return folder / "_out_bin_picking" / "bop"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """What the documented command writes for three OBJ files."""
    return generate(tmp_path_factory.mktemp("bin_picking"))


def scenes(dataset: Path) -> dict[str, dict[str, dict]]:
    return {
        f"{folder.parent.name}/{folder.name}": {
            name: json.loads((folder / f"{name}.json").read_text())
            for name in ("scene_gt", "scene_camera", "scene_gt_info")
        }
        for folder in sorted(dataset.glob("*/[0-9]*"))
    }


@in_soak
def test_a_folder_of_parts_becomes_a_bop_dataset(dataset):
    found = scenes(dataset)
    # A drop is in one part of the dataset; each of its cameras is a scene of two pictures.
    assert list(found) == ["train_pbr/000000", "train_pbr/000001", "val_pbr/000002", "val_pbr/000003"]
    assert all(len(tables["scene_camera"]) == 2 for tables in found.values())
    for tables in found.values():
        for camera in tables["scene_camera"].values():
            np.testing.assert_allclose(camera["cam_K"], LENS["camera_matrix"]["data"], atol=1e-4)
    info = json.loads((dataset / "models" / "models_info.json").read_text())
    sizes = {name: [row[f"size_{axis}"] for axis in "xyz"] for name, row in info.items()}
    # Models are in millimeters and in the axes of their files, whatever these say.
    assert sizes == {
        "1": pytest.approx([120, 80, 50], abs=0.01),
        "2": pytest.approx([24, 3, 18], abs=0.01),
        "3": pytest.approx([200, 100, 150], abs=0.01),
    }
    visible = [
        row["visib_fract"] for tables in found.values() for rows in tables["scene_gt_info"].values() for row in rows
    ]
    assert np.mean(np.array(visible) > 0.5) > 0.5


def test_parts_lie_still_where_they_were_while_cameras_move(dataset):
    assert scenes(dataset)
    for tables in scenes(dataset).values():
        in_world = []
        for frame, camera in tables["scene_camera"].items():
            rotation, shift = np.array(camera["cam_R_w2c"]).reshape(3, 3), np.array(camera["cam_t_w2c"])
            in_world.append(
                {(pose["obj_id"], *np.round(rotation.T @ (np.array(pose["cam_t_m2c"]) - shift), 0)) for pose in
                 tables["scene_gt"][frame]}
            )  # fmt: skip
        shared = set.intersection(*in_world)
        assert len(shared) >= 0.5 * max(map(len, in_world))
        cameras = [np.array(each["cam_t_w2c"]) for each in tables["scene_camera"].values()]
        assert np.linalg.norm(cameras[0] - cameras[1]) > 10
        heights = [place[3] for place in set.union(*in_world)]
        assert min(heights) > -200  # in the bin, whose floor is at 0; origins are off the parts' middles


def test_the_dataset_is_verified(dataset):
    assert "0 faults" in usdsdg("verify", str(dataset), cwd=dataset)


@in_soak
def test_the_same_command_writes_the_same_bytes(dataset, tmp_path):
    again = generate(tmp_path)
    for part in ("train_pbr", "val_pbr", "models"):
        assert digests(dataset / part) == digests(again / part)


@in_soak
def test_a_process_builds_and_fills_only_the_drops_of_its_frames(dataset, tmp_path, monkeypatch):
    write_three(tmp_path / "parts")
    (tmp_path / "lens.yaml").write_text(yaml.safe_dump(LENS))
    monkeypatch.chdir(tmp_path)
    overrides = [each for item in ["meshes=parts", *SMALL] for each in ("--set", item)]
    filled, fill = [], job._fill

    def noted(scene, config, draws, drop):
        filled.append(drop)
        fill(scene, config, draws, drop)

    monkeypatch.setattr(job, "_fill", noted)
    for frames, drops in (("2:4", [1]), ("0:1", [0]), ("1:2", [0])):
        filled.clear()
        code, said = make_part(["generate", str(CONFIG), *overrides, "--frames", frames])
        assert code == 0, said
        assert filled == drops
    usdsdg("merge", "_out_bin_picking", cwd=tmp_path)
    assert digests(tmp_path / "_out_bin_picking" / "bop") == digests(dataset)


@pytest.mark.parametrize("seed", sampled([1, 4, 0, 2, 3, 5]))
def test_all_parts_lie_in_the_bin(stage, tmp_path, monkeypatch, seed):
    # Its floor is thinner than what parts fall in a step: they would get through by themselves.
    inside, fill = [], job.fill

    def noted(bin_, parts, generator, *, max_time):
        fill(bin_, parts, generator, max_time=max_time)
        inside.append([bin_.size.holds(middle_of(part.body)) for part in parts])

    monkeypatch.setattr(job, "fill", noted)
    _, config = load_job(CONFIG, [f"seed={seed}", "drops=3", "parts.collider=convexHull", f"output_dir={tmp_path}"])
    by_label, _ = begin(config, frames_per_scene=config.frames_per_drop)
    list(job._drops(config, read_assets(by_label, config.mesh_unit), []))
    assert [len(each) >= config.parts.per_bin[0] for each in inside] == [True] * 3
    assert all(map(all, inside)), inside


def test_shapes_of_a_class_have_the_same_models_in_every_drop(stage, tmp_path):
    write_three(tmp_path / "parts")
    names = [file.stem for file in sorted((tmp_path / "parts").glob("*.obj"))]
    changes = [f"meshes={tmp_path / 'parts'}", f"labels={{{', '.join(f'{name}: thing' for name in names)}}}"]
    _, config = load_job(CONFIG, [*changes, "drops=3", "parts.per_bin=[1,1]", f"output_dir={tmp_path / 'out'}"])
    by_label, writers = begin(config, frames_per_scene=config.frames_per_drop)
    assets, (_, writer) = read_assets(by_label, "auto"), writers[0]
    job._survey(config, assets, [writer])
    kinds, found = job.kinds_of(assets), []
    assert kinds == [("thing", 0), ("thing", 1), ("thing", 2)]
    for kind in (kinds[2], kinds[0], kinds[1]):  # on a new stage each, at the same path
        (part,) = job.build(config, [kind], assets).parts
        part.body.place(np.zeros(3), Gf.Quatd(1.0))
        writer.survey()
        found += [obj_id for _, obj_id in writer._models._now.values()]
    assert found == [2001, 1, 1001]


def chain(folder: Path, distortion: list[float]) -> Path:
    camera = {
        "camera_model": "pinhole", "intrinsics": [300.0, 302.0, 160.0, 119.0], "distortion_model": "radtan",
        "distortion_coeffs": distortion, "resolution": [320, 240],
    }  # fmt: skip
    second = np.eye(4)
    second[0, 3] = -0.1
    file = folder / "camchain.yaml"
    file.write_text(yaml.safe_dump({"cam0": camera, "cam1": {**camera, "T_cn_cnm1": second.tolist()}}))
    return file


def test_a_rig_moves_as_one_and_looks_at_the_bin(stage, tmp_path):
    changes = [f"meshes={write_three(tmp_path / 'parts')}", f"cameras.calibration={chain(tmp_path, [0.0] * 4)}"]
    _, config = load_job(CONFIG, changes)
    size = suiting(read_assets(files_by_label(config.meshes), "auto"), 30)
    cameras = add_cameras(stage, config.cameras, None, size.radius)
    assert cameras.sizes == [(320, 240)] * 2
    places = []
    for frame in range(3):
        cameras.randomize(Draws(0), frame, size, config.cameras)
        views = [read_camera(stage, prim.GetPath(), (320, 240)) for prim in cameras.cameras]
        places.append(views[0].local_to_world[3, :3])
        np.testing.assert_allclose(
            views[1].local_to_world[3, :3] - places[-1], 0.1 * views[0].local_to_world[0, :3], atol=1e-6
        )
        pixel, depth = views[0].project(np.array([[0.0, 0.0, 0.0]]))
        assert depth[0] > 0
        assert np.abs(pixel[0] - (160, 120)).max() < 60
    assert np.linalg.norm(places[0] - places[1]) > 0.05


def test_a_bin_far_too_large_for_positions_of_its_parts_is_refused(tmp_path):
    write_three(tmp_path)
    assets = read_assets(files_by_label(str(tmp_path)), "m")
    smallest = min(max(np.subtract(each.high, each.low)) for each in assets)
    size = given((20.0, 30.0, 2.0), assets)
    assert (size.width, size.depth, size.height) == (20.0, 30.0, 2.0)
    with pytest.raises(ConfigError, match=r"bin\.size is \[1\.0, 1000000\.0, 1\.0\] m: .* Give at most 10,000 times"):
        given((1.0, 1e6, 1.0), assets)
    most = 9_999.0 * float(smallest)
    given((1.0, most, 1.0), assets)
    assert np.spacing(np.float32(most / 2)) < 1e-3 * smallest


def test_bop_refuses_distorted_lenses_before_any_work(tmp_path):
    changes = [f"cameras.calibration={chain(tmp_path, [-0.2, 0.05, 0.0, 0.0])}"]
    with pytest.raises(ConfigError, match=r"cam0, cam1 has a distorted lens.*cameras.undistorted: true"):
        load_job(CONFIG, changes)
    _, config = load_job(CONFIG, [*changes, "cameras.undistorted=true"])
    assert config.cameras.undistorted


TORN = {
    "torn.obj": b"v 0 0 0\nv 1 0 0\nv 0 1",
    "torn.glb": b"glTF\x02\0\0\0\xff\xff\0\0",
    "torn.usdc": b"PXR-USDC\0\x08",
}


@pytest.mark.parametrize("name", sampled(TORN))
def test_a_torn_mesh_among_good_ones_ends_the_job_before_any_work(tmp_path, monkeypatch, name):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    share_demo_assets(tmp_path / "cache")
    monkeypatch.chdir(tmp_path)
    (write_three(tmp_path / "parts") / name).write_bytes(TORN[name])
    command = ["generate", str(CONFIG), "--set", f"meshes={tmp_path / 'parts'}"]
    ended = CliRunner().invoke(app, command, env={"COLUMNS": "400", "TERM": "dumb"})
    assert ended.exit_code == 1
    [told] = [line for line in ended.stderr.splitlines() if line.startswith("error: ")]
    assert name in told
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and path.suffix in (".png", ".json")
                and "parts" not in path.parts and "cache" not in path.parts]  # fmt: skip
