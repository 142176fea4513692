"""Copies of environments that are all in one place: with ids of environments they do not touch each other."""

import numpy as np
import pytest
from pxr import UsdGeom, UsdPhysics

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.core.cloner import Cloner, GridCloner
from usdsdg.compat.isaacsim.core.prims import RigidPrim
from usdsdg.session.timeline import get_timeline
from usdsdg.stage.physics.ground_plane import add_ground_plane

SIZE, COUNT = 0.2, 4


def environments(stage, clone):
    """Return the boxes of copies after a second of falling to the ground, (N, 3)."""
    UsdPhysics.Scene.Define(stage, "/physicsScene")
    add_ground_plane(stage, "/World/ground")
    UsdGeom.Xform.Define(stage, "/World/env_0")
    box = UsdGeom.Cube.Define(stage, "/World/env_0/box")
    box.CreateSizeAttr(SIZE)
    box.AddTranslateOp().Set((0.0, 0.0, 0.5))
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    UsdPhysics.RigidBodyAPI.Apply(box.GetPrim())
    clone(Cloner(stage).generate_paths("/World/env", COUNT))
    boxes = RigidPrim("/World/env_.*/box", reset_xform_properties=False)
    get_timeline().play()
    for _ in range(60):
        get_app().update()
    return np.array(boxes.get_world_poses()[0])


@pytest.mark.parametrize("copy_from_source", [True, False])
def test_copies_in_one_place_rest_in_each_other_where_they_have_ids(stage, copy_from_source):
    def clone(paths):
        places = np.zeros((COUNT, 3))
        Cloner(stage).clone(
            "/World/env_0",
            paths,
            places,
            replicate_physics=True,
            copy_from_source=copy_from_source,
            enable_env_ids=True,
        )

    found = environments(stage, clone)
    assert found == pytest.approx(np.tile([0, 0, SIZE / 2], (COUNT, 1)), abs=2e-3)


def test_a_grid_without_spacing_keeps_ids(stage):
    def clone(paths):
        GridCloner(0.0).clone("/World/env_0", paths, replicate_physics=True, enable_env_ids=True)

    assert environments(stage, clone) == pytest.approx(np.tile([0, 0, SIZE / 2], (COUNT, 1)), abs=2e-3)


@pytest.mark.parametrize("options", [{"enable_env_ids": True}, {"replicate_physics": True}])
def test_copies_without_ids_push_each_other_away(stage, options):
    """The ids are those of the replicator of PhysX."""
    found = environments(stage, lambda paths: GridCloner(0.0).clone("/World/env_0", paths, **options))
    assert np.ptp(found, axis=0).max() > SIZE / 2
