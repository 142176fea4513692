"""Foreign import names resolve to modules of usdsdg, and only after `compat.install()`."""

import subprocess
import sys
import textwrap


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_an_import_without_them_says_what_brings_them_and_a_question_is_answered():
    printed = run(
        """
        import usdsdg
        from importlib.util import find_spec
        for name in ("omni.usd", "carb", "isaacsim.core.api", "usdrt"):
            try:
                __import__(name)
            except ModuleNotFoundError as error:
                print(error.name, "usdsdg.compat.install()" in str(error), "`usdsdg run`" in str(error))
        print(find_spec("omni"), find_spec("carb"))
        import usdsdg.compat; usdsdg.compat.install()
        import omni.usd, carb, isaacsim.core.api, usdrt
        """
    )
    assert printed.splitlines() == [
        *(f"{name} True True" for name in ("omni", "carb", "isaacsim", "usdrt")),
        "None None",
    ]


def test_both_names_import_the_same_module():
    assert (
        run(
            """
            import usdsdg.compat; usdsdg.compat.install()
            import omni.replicator.core as rep, usdsdg
            import omni.replicator.core.distribution as d
            import usdsdg.distribution, usdsdg.session.timeline
            import omni.timeline
            print(rep is usdsdg, d is usdsdg.distribution,
                  omni.timeline.get_timeline_interface() is usdsdg.session.timeline.get_timeline())
            """
        )
        == "True True True"
    )


def test_every_import_of_the_tutorial_script_resolves():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import carb.settings
        import omni.kit.app, omni.replicator.core as rep, omni.timeline, omni.usd, usdrt, usdrt.Sdf, Semantics
        from omni.isaac.core.utils.semantics import add_update_semantics, remove_all_semantics
        from omni.isaac.nucleus import get_assets_root_path
        from omni.kit.viewport.utility import get_active_viewport
        from omni.physx import get_physx_interface, get_physx_scene_query_interface
        from pxr import Gf, OmniScriptingSchema, PhysxSchema, Sdf, Usd, UsdGeom, UsdPhysics
        carb.Float3((1, 2, 3)); carb.Float4(0, 0, 0, 1)
        """
    )


def test_rotations_and_files_are_found_by_the_names_of_both_versions():
    assert (
        run(
            """
            import usdsdg.compat; usdsdg.compat.install()
            import isaacsim.core.utils.numpy.rotations as rot_utils
            import omni.isaac.core.utils.numpy.rotations as old_rot_utils
            from isaacsim.core.utils.numpy import euler_angles_to_quats
            from isaacsim.core.utils.nucleus import is_file
            from isaacsim.storage.native import is_dir
            from omni.isaac.core.utils.nucleus import is_file as old_is_file
            from omni.isaac.core.utils.random import get_random_world_pose_in_view
            from isaacsim.core.utils.random import get_random_world_pose_in_view as new_pose_in_view
            print(rot_utils.euler_angles_to_quats is old_rot_utils.euler_angles_to_quats is euler_angles_to_quats,
                  is_file is old_is_file, get_random_world_pose_in_view is new_pose_in_view)
            """
        )
        == "True True True"
    )


def test_writers_of_isaac_sim_are_the_same_classes_by_all_their_names():
    assert (
        run(
            """
            import usdsdg.compat; usdsdg.compat.install()
            from isaacsim.replicator.writers import DOPEWriter, PytorchListener, PytorchWriter, YCBVideoWriter
            from isaacsim.replicator.writers.scripts.writers import DOPEWriter as ours
            from omni.replicator.isaac.scripts.writers import DOPEWriter as old
            from omni.replicator.isaac.scripts.writers.dope_writer import DOPEWriter as oldest
            from omni.replicator.isaac.scripts.writers.pytorch_listener import PytorchListener as listener
            from omni.replicator.isaac.scripts.writers.pytorch_writer import PytorchWriter as writer
            import omni.replicator.core as rep
            import omni.replicator.isaac as dr
            print(DOPEWriter is ours is old is oldest, PytorchListener is listener, PytorchWriter is writer,
                  type(rep.WriterRegistry.get("YCBVideoWriter")) is YCBVideoWriter, hasattr(dr, "physics_view"))
            """
        )
        == "True True True True True"
    )


def test_importing_a_missing_module_explains_the_gap():
    assert "has no counterpart in usdsdg yet" in run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        try:
            import omni.nothing
        except ModuleNotFoundError as error:
            print(error)
        """
    )


def test_importing_usdsdg_installs_no_foreign_name():
    assert (
        run(
            """
            import usdsdg
            try:
                import omni.usd
            except ModuleNotFoundError:
                print("absent")
            """
        )
        == "absent"
    )


def test_importing_usdsdg_loads_no_engine():
    loaded = run("import sys, usdsdg; print([m for m in ('warp', 'newton', 'pydantic', 'click') if m in sys.modules])")
    assert loaded == "[]"


def test_usdrt_finds_applied_schemas():
    assert (
        run(
            """
            import usdsdg.compat; usdsdg.compat.install()
            import omni.usd, usdrt
            from pxr import PhysxSchema, UsdPhysics
            stage = omni.usd.get_context().get_stage()
            UsdPhysics.Scene.Define(stage, "/PhysicsScene")
            PhysxSchema.PhysxSceneAPI.Apply(stage.GetPrimAtPath("/PhysicsScene"))
            attached = usdrt.Usd.Stage.Attach(omni.usd.get_context().get_stage_id())
            print(attached.GetPrimsWithAppliedAPIName("PhysxSceneAPI"))
            """
        )
        == "[Sdf.Path('/PhysicsScene')]"
    )


def test_writers_backends_and_annotators_are_where_scripts_import_them_from():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core as rep
        from omni.replicator.core import AnnotatorRegistry, BackendDispatch, NodeConnectionTemplate, Writer
        from omni.replicator.core import BasicWriter, WriterRegistry, WriterRegistryError
        from omni.replicator.core.scripts.annotators import Augmentation
        from omni.replicator.core.scripts.backends import BackendDispatch as same, BackendGroup, BaseBackend
        from omni.replicator.core.scripts.writers_default.basicwriter import BasicWriter as basic
        assert same is BackendDispatch is rep.backends.BackendDispatch
        assert basic is BasicWriter is rep.writers_default.BasicWriter
        assert Augmentation is rep.annotators.Augmentation
        from omni.replicator.core.scripts.writers_default.tools import colorize_segmentation
        assert rep.tools.colorize_segmentation is colorize_segmentation
        assert rep.backends.get("DiskBackend").get_name() == "DiskBackend"
        assert rep.backends.io_queue.is_done_writing()
        assert "rgb" in rep.annotators_default.DEFAULT_ANNOTATORS
        rep.annotators.Augmentation.from_function(rep.augmentations_default.aug_rgb_to_hsv)
        """
    )


def test_copies_of_replicators_writers_find_what_they_import():
    # The head and the constructor of omni.replicator.core 1.12.27's BasicWriter, of which projects keep changed copies.
    run(
        """
        import tempfile
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core as rep
        from omni.replicator.core.backends.base import BaseBackend
        from omni.replicator.core.backends.dispatcher import BackendDispatch
        from omni.replicator.core.bindings._omni_replicator_core import Schema_omni_replicator_extinfo_1_0
        from omni.replicator.core.scripts.backends.disk import DiskBackend
        assert (BaseBackend, BackendDispatch) == (rep.backends.BaseBackend, rep.backends.BackendDispatch)
        folders = tempfile.mkdtemp(), tempfile.mkdtemp()
        given, own = DiskBackend(folders[0]), BackendDispatch(output_dir=folders[1])
        group = rep.backends.BackendGroup([given, *own._backends])
        assert [each.output_dir for each in group._backends] == list(folders)
        assert Schema_omni_replicator_extinfo_1_0().any_event(1, name="x") is None
        """
    )


def test_utilities_are_where_scripts_import_them_from():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core as rep
        import omni.replicator.core.functional.io_functions as io_functions
        from omni.replicator.core.utils.rng import ReplicatorRNG, get_global_seed, set_global_seed
        from omni.replicator.core.utils.utils import ReplicatorItem, compute_aabb, find_prims, set_target_prims
        assert ReplicatorRNG is rep.rng.ReplicatorRNG
        set_global_seed(11)
        assert get_global_seed() == rep.get_global_seed() == 11
        assert io_functions.write_png is rep.functional.write_png
        assert find_prims is rep.utils.find_prims
        from omni.replicator.core.scripts.utils.viewport_manager import HydraTexture
        assert isinstance(rep.create.render_product(rep.create.camera(), (8, 8)), HydraTexture)
        from omni.replicator.core.scripts.backends.io_queue import wait_until_done
        from omni.replicator.core.backends import io_queue
        wait_until_done()
        assert io_queue.is_done_writing() and rep.backends.io_queue.is_done_writing()
        """
    )


def test_imports_of_isaac_sim_4_choose_its_payloads():
    code = """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core, omni.usd, isaacsim
        from usdsdg.session.settings.replicator_version import replicator_version
        before = replicator_version()
        try:
            import omni.isaac.nothing_of_this_name
        except ImportError:
            before += replicator_version()
        {}
        print(before, replicator_version())
    """
    assert run(code.format("from omni.isaac.core.utils.semantics import add_update_semantics")) == "12 4"
    assert run(code.format("import omni.isaac.kit")) == "12 4"
    assert run(code.format("import isaacsim.core.utils.semantics")) == "12 6"


def test_the_core_of_isaac_sim_4_is_that_of_later_versions():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import isaacsim.core.api, isaacsim.core.prims, isaacsim.core.utils.prims as newer
        import omni.isaac.core.utils.prims as prims_utils
        from omni.isaac.core import World
        from omni.isaac.core.materials.omni_pbr import OmniPBR
        from omni.isaac.core.objects import DynamicCuboid, cuboid
        from omni.isaac.core.prims import RigidPrim, RigidPrimView, XFormPrim
        from omni.isaac.core.prims.rigid_contact_view import RigidContactView as oldest
        from omni.isaac.core.prims.xform_prim_view import XFormPrimView
        from omni.isaac.core.sensors import RigidContactView as older
        from omni.isaac.core.simulation_context import SimulationContext
        from omni.isaac.core.utils.rotations import euler_angles_to_quat
        from omni.isaac.core.utils.viewports import set_camera_view
        from omni.isaac.cloner import GridCloner
        from omni.isaac.version import get_version
        from isaacsim.core.api.sensors.rigid_contact_view import RigidContactView
        from isaacsim.core.simulation_manager.impl.isaac_events import IsaacEvents
        from isaacsim.core.prims import SingleArticulation  # known, and out of scope
        assert World is isaacsim.core.api.World
        assert prims_utils is newer
        assert RigidPrim is isaacsim.core.prims.SingleRigidPrim
        assert RigidPrimView is isaacsim.core.prims.RigidPrim
        assert XFormPrimView is isaacsim.core.prims.XFormPrim
        assert cuboid.DynamicCuboid is DynamicCuboid
        assert RigidContactView is older is oldest
        """
    )


def test_importing_the_core_wrappers_loads_neither_warp_nor_newton_nor_scipy():
    assert (
        run(
            """
            import sys, usdsdg.compat; usdsdg.compat.install()
            import isaacsim.core.api.objects, isaacsim.core.cloner, isaacsim.core.rendering_manager
            import isaacsim.core.experimental.objects, isaacsim.core.experimental.utils.transform
            print([m for m in ("warp", "newton", "scipy") if m in sys.modules])
            """
        )
        == "[]"
    )


def test_the_product_of_the_viewport_is_not_destroyed_with_the_others():
    run(
        """
        import usdsdg.compat; usdsdg.compat.install()
        import omni.replicator.core as rep
        from omni.kit.viewport.utility import get_active_viewport
        from omni.replicator.core.scripts.utils import viewport_manager
        viewport, own = get_active_viewport(), rep.create.render_product(rep.create.camera(), (8, 8))
        path = viewport.get_render_product_path()
        viewport_manager.destroy_hydra_textures()
        stage = rep.get_stage()
        assert stage.GetPrimAtPath(path) and not stage.GetPrimAtPath(own.path)
        """
    )
