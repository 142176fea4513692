"""Names that existing scripts import from unusual places, and what they do."""

import asyncio

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg
from tests.compat.test_imports import run
from usdsdg.compat.isaacsim.core.utils import viewports
from usdsdg.compat.isaacsim.core.utils.physics import simulate_async
from usdsdg.compat.isaacsim.sensors.camera import SingleViewDepthSensor
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.kit.viewport.utility.camera_state import ViewportCameraState
from usdsdg.compat.prim_copies import duplicate_prim
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.session.stage_context import current_stage, new_stage


@pytest.fixture(autouse=True)
def _empty_stage():
    new_stage()


def test_utilities_are_found_in_the_modules_that_import_them_in_replicator():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core as rep
        from omni.replicator.core.scripts.create import ReplicatorItem, render_product
        from omni.replicator.core.scripts.modify import ReplicatorWrapper, set_target_prims
        from omni.replicator.core.scripts.randomizer import create_node
        from omni.replicator.core.scripts.trigger import ReplicatorWrapper as same
        from omni.replicator.core.scripts.annotator_registry import AnnotatorRegistry
        from omni.replicator.core.scripts.writer_registry import WriterRegistry
        from omni.replicator.core.scripts.utils import annotator_utils
        from omni.isaac.sensor.scripts.camera import Camera
        from omni.isaac.core.utils.nucleus import find_nucleus_server
        from isaacsim.core.utils.constants import AXES_INDICES
        from isaacsim.core.utils.math import cross, normalized
        assert ReplicatorItem is rep.utils.ReplicatorItem and ReplicatorWrapper is same
        assert AnnotatorRegistry is rep.AnnotatorRegistry and WriterRegistry is rep.WriterRegistry
        found, root = find_nucleus_server()
        assert found and root
        try:
            from omni.replicator.core.scripts.create import not_there
        except ImportError as error:
            assert "not_there" in str(error)
        else:
            raise AssertionError
        """
    )


def test_a_duplicate_has_the_opinions_of_all_layers_and_leaves_the_source():
    stage = current_stage()
    weak = Sdf.Layer.CreateAnonymous()
    stage.GetRootLayer().subLayerPaths.append(weak.identifier)
    with Usd.EditContext(stage, weak):
        UsdGeom.Cube.Define(stage, "/World/Box").GetSizeAttr().Set(3.0)
        UsdGeom.Sphere.Define(stage, "/World/Box/Ball")
    UsdGeom.XformCommonAPI(stage.OverridePrim("/World/Box")).SetTranslate((1, 2, 3))
    assert duplicate_prim(stage, "/World/Box", Sdf.Path("/World/Copies/Box_1"))
    copy = UsdGeom.Cube(stage.GetPrimAtPath("/World/Copies/Box_1"))
    assert copy.GetSizeAttr().Get() == 3.0
    assert stage.GetPrimAtPath("/World/Copies/Box_1/Ball").GetTypeName() == "Sphere"
    assert UsdGeom.XformCache().GetLocalToWorldTransform(copy.GetPrim()).ExtractTranslation() == Gf.Vec3d(1, 2, 3)
    assert stage.GetPrimAtPath("/World/Box")
    with pytest.raises(BadPrim, match="/World/None is not on the stage"):
        duplicate_prim(stage, "/World/None", "/World/Other")


def test_the_state_of_a_camera_aims_it_and_keeps_its_target():
    usdsdg.create.camera(name="Eye")
    path = next(str(prim.GetPath()) for prim in current_stage().Traverse() if prim.GetTypeName() == "Camera")
    state = ViewportCameraState(path)
    state.set_position_world(Gf.Vec3d(5, 0, 2), True)
    state.set_target_world(Gf.Vec3d(0, 0, 1), True)
    assert np.allclose(state.position_world, (5, 0, 2))
    assert np.allclose(state.target_world, (0, 0, 1))
    ahead = UsdGeom.XformCache().GetLocalToWorldTransform(state.usd_camera.GetPrim()).TransformDir((0, 0, -1))
    assert np.allclose(ahead, Gf.Vec3d(-5, 0, -1).GetNormalized())
    state.set_position_world(Gf.Vec3d(5, 1, 2), False)
    assert np.allclose(state.target_world, (0, 1, 1))


def test_intrinsics_of_the_viewport_are_those_of_the_image():
    stage = current_stage()
    rig = UsdGeom.Xform.Define(stage, "/World/Rig")
    rig.AddTranslateOp().Set((0, 0, 4))
    rig.AddScaleOp().Set((0.1, 0.1, 0.1))
    UsdGeom.Camera.Define(stage, "/World/Rig/Eye")
    UsdGeom.Cube.Define(stage, "/World/Box").GetSizeAttr().Set(0.4)
    viewport = get_active_viewport()
    viewport.camera_path, viewport.resolution = "/World/Rig/Eye", (64, 48)
    matrix = np.array([[80.0, 0, 40.0], [0, 80.0, 20.0], [0, 0, 1]])
    viewports.set_intrinsics_matrix(viewport, matrix, 24.0)
    assert np.allclose(viewports.get_intrinsics_matrix(viewport), matrix)
    depth = usdsdg.annotators.get("distance_to_image_plane").attach(viewport.render_product_path)
    usdsdg.orchestrator.step()
    rows, columns = np.nonzero(np.isfinite(depth.get_data()))
    # The box is on the optical axis, which the matrix puts at 40, 20.
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx((40, 20), abs=0.51)
    points = np.array(
        [tuple(point) for point in viewports.project_depth_to_worldspace(depth.get_data(), viewport, 9.0)]
    )
    seen = points.reshape(48, 64, 3)[rows, columns]
    assert np.allclose(seen[:, 2], 0.2, atol=1e-5)
    # The face is 0.4 wide, and a pixel 3.8 / 80.
    assert np.abs(seen[:, :2]).max(axis=0) == pytest.approx([0.2 - 3.8 / 160] * 2, abs=3.8 / 160)
    assert seen[:, :2].mean(axis=0) == pytest.approx([0, 0], abs=1e-5)
    with pytest.raises(ArgumentError, match=r"expected \(3, 3\)"):
        viewports.set_intrinsics_matrix(viewport, np.eye(4))


def test_a_depth_sensor_measures_and_has_its_parameters_on_the_render_product():
    stage = current_stage()
    UsdGeom.Cube.Define(stage, "/World/Box")
    usdsdg.create.light(light_type="dome")
    sensor = SingleViewDepthSensor("/World/Eye", position=(-4, 0, 0), resolution=(32, 24))
    assert sensor.get_baseline_mm() is None
    sensor.initialize()
    sensor.set_baseline_mm(40)
    sensor.set_noise_sigma(0)
    sensor.set_noise_mean(0)
    sensor.set_confidence_threshold(0.0)
    sensor.initialize()
    product = stage.GetPrimAtPath(sensor.get_render_product_path())
    assert product.GetAttribute("omni:rtx:post:depthSensor:baselineMM").Get() == 40
    assert sensor.get_enabled()
    assert sensor.get_max_disparity_pixel() == 110
    sensor.attach_annotator("DepthSensorDistance")
    sensor.attach_annotator("distance_to_image_plane")
    usdsdg.orchestrator.step()
    frame = {name: note.get_data() for name, note in sensor._custom_annotators.items()}
    assert frame["DepthSensorDistance"].shape == (24, 32)
    assert frame["distance_to_image_plane"][12, 16] == pytest.approx(3.0, abs=1e-4)


def test_simulate_async_calls_back_after_each_step():
    calls = []
    asyncio.run(simulate_async(0.1, 60, lambda: calls.append(1)))
    assert len(calls) == 6


def test_commands_are_classes_too():
    told = run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.usd, omni.usd.commands
        from omni.usd.commands import CreatePrimCommand, DeletePrimsCommand
        stage = omni.usd.get_context().get_stage()
        CreatePrimCommand("Xform", "/World/a").do()
        omni.usd.commands.CreatePrimCommand(prim_type="Cube", prim_path="/World/b").do()
        DeletePrimsCommand(["/World/a"]).do()
        print([str(prim.GetPath()) for prim in stage.GetPrimAtPath("/World").GetChildren()])
        try:
            omni.usd.commands.CreatePrmCommand
        except AttributeError as error:
            print(error)
        """
    )
    names, error = told.splitlines()
    assert names == "['/World/b']"
    assert "omni.usd.commands of usdsdg has no 'CreatePrmCommand'; did you mean CreatePrimCommand" in error


def test_modules_of_older_releases_are_found_by_their_names():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        from isaacsim import AppFramework, SimulationApp
        from isaacsim.core.api import PhysicsContext, SimulationContext, World
        from isaacsim.core.experimental.prims.impl import RigidPrim
        from isaacsim.core.experimental.utils.impl import transform
        from isaacsim.core.utils.impl.stage import get_current_stage
        from isaacsim.simulation_app.app_framework import AppFramework as of_app
        from isaacsim.storage.native.impl.file_utils import find_filtered_files
        from omni.isaac.benchmark.services import BaseIsaacBenchmark
        from omni.isaac.core.physics_context.physics_context import PhysicsContext as old_physics
        from omni.isaac.core.simulation_context.simulation_context import SimulationContext as old_context
        from omni.isaac.core.utils.collisions import ray_cast
        from omni.isaac.core.utils.distance_metrics import rotational_distance_angle
        from omni.isaac.core.world.world import World as old_world
        from omni.isaac.kit.simulation_app import SimulationApp as old_app
        from omni.isaac.kit.utils import create_new_stage, set_carb_setting
        from omni.isaac.nucleus.nucleus import get_assets_root_path
        from omni.isaac.sensor.scripts.camera_view import CameraView
        from omni.usd.utils import get_world_transform_matrix
        import isaacsim.core.experimental.prims as prims, isaacsim.core.utils.stage as stage
        assert (old_physics, old_context, old_world) == (PhysicsContext, SimulationContext, World)
        assert old_app is SimulationApp and of_app is AppFramework and RigidPrim is prims.RigidPrim
        assert get_current_stage is stage.get_current_stage
        """
    )


def test_the_framework_of_the_application_takes_settings_and_updates():
    run(
        """
        import asyncio
        import usdsdg.compat; usdsdg.compat.install()
        from isaacsim import AppFramework
        app = AppFramework("test", ["--empty", "--/app/ours/count=3", "--enable", "omni.usd"])
        import carb, omni.usd
        task = asyncio.ensure_future(omni.usd.get_context().new_stage_async())
        while not task.done():
            app.update()
        assert task.result() == (True, "") and carb.settings.get_settings().get("/app/ours/count") == 3
        assert app.app.is_running()
        app.close()
        assert not app.app.is_running()
        """
    )


def test_there_is_no_window_to_close():
    product = usdsdg.create.render_product(usdsdg.create.camera(), (8, 8))
    viewports.destroy_all_viewports()
    assert viewports.get_id_from_index(0) is None
    assert viewports.get_window_from_id(3) is None
    assert current_stage().GetPrimAtPath(product.path)
