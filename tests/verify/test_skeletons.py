"""`usdsdg verify` reads BasicWriter's skeletons, and finds what is damaged in them."""

import json
import shutil

import numpy as np
import pytest
from pxr import Gf, UsdGeom

import usdsdg as rep
from tests.annotators.kinds.test_skeleton import add_character
from tests.annotators.ray_caster import add_cube, place
from tests.verify.label_faults import edit_json
from usdsdg.session import session
from usdsdg.session.stage_context import new_stage
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.verify import verify


@pytest.fixture(scope="module", params=[("rgb", "instance_id_segmentation"), ()], ids=["beside images", "alone"])
def clean(request, tmp_path_factory):
    """A frame with a character that a box hides in part, one that reaches out of the picture, and one behind it."""
    folder = tmp_path_factory.mktemp("skeletons")
    session.restart()
    stage = new_stage()
    for index, position in enumerate(((-1, 0, 0), (1.5, 1, 0), (-20, 0, 0))):
        place(add_character(stage, f"/World/Man{index}"), translate=position)
    add_cube(stage, "/World/Box", "box", size=0.3, translate=(0, 0, 1))
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.CreateFocalLengthAttr(20)
    camera.AddTransformOp().Set(Gf.Matrix4d(look_at_matrix((-5, 0, 5), (0, 0, 0))))
    writer = rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(folder), skeleton_data=True, **dict.fromkeys(request.param, True))
    writer.attach([rep.create.render_product("/World/Camera", (64, 48))])
    rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    session.restart()
    assert verify(folder).faults == []
    return folder


def set_to(key, value, joint=None):
    def edit(table):
        if joint is None:
            table["skeleton_0"][key] = value
        else:
            table["skeleton_0"][key][joint] = value

    return edit


FAULTS = {
    "a pixel": set_to("translations_2d", [1.0, 2.0], 1),
    "no pixel": set_to("translations_2d", [None, None], 1),
    "a place": set_to("global_translations", [0.0, 0.0, 1.0], 1),
    "a parent": set_to("skeleton_parents", 0, 2),
    "a root": set_to("skeleton_parents", -1, 1),
    "a rotation": set_to("local_rotations", [2.0, 0.0, 0.0, 0.0], 1),
    "a rotation at rest": set_to("rest_local_rotations", [0.0, 0.0, 0.0, 0.0], 1),
    "an occlusion": lambda table: table["skeleton_0"]["joint_occlusions"].reverse(),
    "a background": set_to("occlusion_types", ["BACKGROUND"] * 3),
    "out of view": set_to("occlusion_types", ["OUT_OF_VIEW"] * 3),
    "in view": set_to("in_view", False),
    "a joint less": lambda table: table["skeleton_0"]["global_translations"].pop(),
    "no joints": lambda table: table["skeleton_0"].pop("skeleton_joints"),
    "text": set_to("global_translations", ["a", "b", "c"]),
    "swapped": lambda table: table.update(
        skeleton_0=table["skeleton_0"] | {"translations_2d": table["skeleton_1"]["translations_2d"]}
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_in_its_file(name, clean, tmp_path):
    folder = shutil.copytree(clean, tmp_path / "damaged", ignore=shutil.ignore_patterns("journal*"))
    assert verify(folder).faults == []
    edit_json(folder / "skeleton_0000.json", FAULTS[name])
    assert {fault.file for fault in verify(folder).faults} == {"skeleton_0000.json"}


def test_the_scene_shows_all_kinds_of_joints(clean):
    table = json.loads((clean / "skeleton_0000.json").read_text())
    occluders = {each for skeleton in table.values() for each in skeleton["occlusion_types"]}
    assert occluders >= {"None", "OUT_OF_VIEW", "box"}
    assert np.isnan(np.array(table["skeleton_2"]["translations_2d"], float)).all()
