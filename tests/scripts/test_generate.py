"""`usdsdg generate` and `usdsdg run` from the outside: files, repeatability, saved stage, errors."""

import hashlib
import json
import textwrap
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Usd, UsdGeom, UsdPhysics
from scipy.spatial.transform import Rotation

from tests.sampled_cases import in_soak
from tests.scripts.conftest import ROOT, generate, usdsdg


def digest(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_every_view_has_an_image_an_overlay_and_a_json_file(posed):
    names = sorted(path.name for path in posed.iterdir() if path.is_file())
    assert names == sorted(
        [f"{i:06d}{suffix}" for i in range(4) for suffix in (".json", ".png", "_overlay.png")] + ["metadata.txt"]
    )
    for path in posed.glob("*.png"):
        assert Image.open(path).size == (160, 120)
    for path in posed.glob("*.json"):
        assert json.loads(path.read_text()).keys() == {"camera_data", "keypoint_order", "objects"}


def test_poses_of_the_shipped_configuration_fit_the_image(posed):
    """Keypoints in the object's frame, transformed by the camera-frame pose and projected, are at their pixels."""
    count = 0
    for path in sorted(posed.glob("*.json")):
        data = json.loads(path.read_text())
        lens = data["camera_data"]["intrinsics"]
        for seen in data["objects"]:
            w, *xyz = seen["quat_wxyz_world_frame"]
            own = np.array(seen["cuboid_keypoints_world_frame"]) - seen["location_world_frame"]
            own = Rotation.from_quat([*xyz, w]).inv().apply(own)
            w, *xyz = seen["quat_wxyz_camera_frame"]
            x, y, z = (Rotation.from_quat([*xyz, w]).apply(own) + seen["location_camera_frame"]).T
            pixels = np.stack([lens["cx"] - lens["fx"] * x / z, lens["cy"] + lens["fy"] * y / z], axis=1)
            # Points beside or behind the camera have no pixel; written pixels are whole numbers.
            ahead = z < -0.05
            assert np.abs(pixels - seen["cuboid_keypoints_projected"])[ahead].max(initial=0) <= 0.51
            count += ahead.sum()
    assert count >= 18


def test_the_same_seed_writes_the_same_bytes(posed, tmp_path):
    assert digest(generate(tmp_path)) == digest(posed)


@in_soak
def test_another_seed_writes_other_images(posed, tmp_path):
    other = digest(generate(tmp_path, "seed=1"))
    assert other["000000.png"] != digest(posed)["000000.png"]


def test_the_saved_stage_opens_with_standard_schemas(tmp_path):
    usdsdg(
        "generate", str(ROOT / "configs" / "object_based.yaml"), "--quiet", "--save-stage", "last.usda",
        "--set=num_frames=1", "--set=resolution=[16,12]", "--set=mesh_distractors_num=2",
        "--set=shape_distractors_num=2", "--set=path_tracing.every=0", cwd=tmp_path,
    )  # fmt: skip
    stage = Usd.Stage.Open(str(tmp_path / "last.usda"))
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert len(bodies) == 16
    assert not stage.GetCompositionErrors()
    assert any(prim.HasAuthoredReferences() for prim in bodies)
    assert 'prepend apiSchemas = ["PhysicsRigidBodyAPI"' in (tmp_path / "last.usda").read_text()
    position = UsdGeom.Xformable(bodies[0]).GetLocalTransformation().ExtractTranslation()
    assert all(abs(value) < 3 for value in position)


SCRIPT = """
    import asyncio
    import sys
    import omni.kit.app
    import omni.replicator.core as rep
    import omni.timeline
    import omni.usd

    async def main():
        stage = omni.usd.get_context().get_stage()
        rep.create.light(light_type="Dome")
        cube = rep.create.cube(semantics=[("class", "cube")])
        with rep.trigger.on_frame():
            with cube:
                rep.modify.pose(position=rep.distribution.uniform((-.2, -.2, -.2), (.2, .2, .2)))
        camera = rep.create.camera(position=(3, 0, 0), look_at=(0, 0, 0), clipping_range=(0.01, 100))
        product = rep.create.render_product(camera, (32, 32))
        rep.orchestrator.set_capture_on_play(False)
        writer = rep.WriterRegistry.get("BasicWriter")
        writer.initialize(output_dir=sys.argv[1], rgb=True, bounding_box_2d_tight=True)
        writer.attach(product)
        for _ in range(3):
            await omni.kit.app.get_app().next_update_async()
            await rep.orchestrator.step_async(rt_subframes=1, delta_time=0.0)
        await rep.orchestrator.wait_until_complete_async()
        print("done", omni.timeline.get_timeline_interface().get_current_time())

    asyncio.ensure_future(main())
"""


def test_a_script_editor_script_runs_and_ends_by_itself(tmp_path):
    (tmp_path / "script.py").write_text(textwrap.dedent(SCRIPT))
    done = usdsdg("run", "--quiet", "script.py", str(tmp_path / "out"), cwd=tmp_path)
    assert "done 0.0" in done.stdout
    assert len(list((tmp_path / "out").glob("rgb_*.png"))) == 3


def test_a_failing_script_shows_its_own_lines(tmp_path):
    (tmp_path / "script.py").write_text("def inner():\n    raise KeyError('lost')\ninner()\n")
    done = usdsdg("run", "--quiet", "script.py", cwd=tmp_path, expect=1)
    assert 'script.py", line 2, in inner' in done.stderr
    assert "usdsdg/app/app.py" not in done.stderr


def test_a_misspelled_writer_is_an_error_that_names_a_similar_one_and_the_line(tmp_path):
    (tmp_path / "script.py").write_text("import omni.replicator.core as rep\nrep.writers.get('PoseWritr')\n")
    done = usdsdg("run", "--quiet", "script.py", cwd=tmp_path, expect=1)
    assert "PoseWriter" in done.stderr
    assert "script.py:2" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_folder_that_cannot_be_written_is_an_error_that_names_it(tmp_path):
    (tmp_path / "file").write_text("in the way")
    done = usdsdg(
        "generate", str(ROOT / "configs" / "object_based.yaml"), "--quiet",
        "--set=writer_kwargs.output_dir=file/out", "--set=num_frames=1", "--set=resolution=[16,12]",
        "--set=mesh_distractors_num=0", "--set=shape_distractors_num=0", cwd=tmp_path, expect=1,
    )  # fmt: skip
    assert "file/out" in done.stderr
    assert "Traceback" not in done.stderr
