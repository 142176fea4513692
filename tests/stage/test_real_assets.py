"""The stage layer on real assets; runs where an assets root is configured."""

import os
from pathlib import Path

import pytest
from pxr import Tf, Usd, UsdGeom

from usdsdg.session import stage_context
from usdsdg.stage import assets, paths
from usdsdg.stage.poses import transforms
from usdsdg.stage.poses.rotations import decompose, euler_xyz_from_quat
from usdsdg.stage.poses.xform_ops import author_pose
from usdsdg.stage.semantics import labels

pytestmark = pytest.mark.skipif(not os.environ.get(assets.ROOT_VARIABLE), reason="no assets root is configured")


def meshes(stage):
    return sorted(str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))


def test_props_are_referenced_posed_labeled_and_saved(tmp_path):
    folder = Path(assets.assets_root()) / "Isaac"
    files = sorted(folder.rglob("*.usd"))[:40]
    stage = stage_context.new_stage()
    for file in files:
        url = "/Isaac/" + str(file.relative_to(folder))
        prim = stage.DefinePrim(paths.next_free_path(stage, f"/World/{Tf.MakeValidIdentifier(file.stem)}"), "Xform")
        prim.GetReferences().AddReference(assets.resolve(url))
        author_pose(prim, translate=(1, 2, 3), rotate_xyz=(10, 20, 30), scale=(2, 2, 2))
        labels.remove_labels(prim, recursive=True)
        assert not any(labels.get_labels(each) for each in Usd.PrimRange(prim))
        labels.add_labels(prim, {"class": file.stem})
        # Assets have their own ops; the pose must be the requested one anyway.
        pose = decompose(transforms.as_array(UsdGeom.Xformable(prim).GetLocalTransformation()))
        assert pose.translate == pytest.approx([1, 2, 3])
        assert pose.scale == pytest.approx([2, 2, 2], rel=1e-5)
        assert euler_xyz_from_quat(pose.rotation) == pytest.approx([10, 20, 30], abs=1e-3)
    assert assets.missing_dependencies(stage) == []
    before = meshes(stage)
    assert before
    saved = Usd.Stage.Open(str(stage_context.save_stage(tmp_path / "out" / "saved.usd")))
    assert meshes(saved) == before
    assert assets.missing_dependencies(saved) == []
    stage_context.new_stage()
