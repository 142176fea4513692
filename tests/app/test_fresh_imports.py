"""Each module with session state works when it is the only one that a script imports."""

import subprocess
import sys
import textwrap

import pytest

from tests.sampled_cases import sampled

SCRIPTS = {
    "a stage that is made before anything else of ours is loaded has our schemas": """
        import usdsdg as rep, os
        from pxr import Usd
        stage = Usd.Stage.CreateInMemory()
        made = stage.DefinePrim("/World", "Xform").ApplyAPI("PhysxRigidBodyAPI")
        rep.create.cube()
        print(made and "PXR_PLUGINPATH_NAME" not in os.environ)
    """,
    "pxr may be loaded first": """
        from pxr import Usd
        import usdsdg as rep
        stage = Usd.Stage.CreateInMemory()
        print(stage.DefinePrim("/World", "Xform").ApplyAPI("PhysxRigidBodyAPI"))
    """,
    "the timeline drives physics": """
        from usdsdg.session.timeline import get_timeline
        get_timeline().play()
        from usdsdg.session.engines import physics_if_made
        print(physics_if_made().is_playing)
    """,
    "updates of a playing timeline are captured": """
        from usdsdg.app.app import get_app
        from usdsdg import annotators, create, settings
        settings.carb_settings("/app/player/playSimulations", False)
        rgb = annotators.get("camera_params").attach(create.render_product(create.camera(), (8, 8)))
        from usdsdg.session.timeline import get_timeline
        get_timeline().play()
        get_app().update()
        print(len(rgb.get_data()["cameraViewTransform"]) == 16)
    """,
    "the seed follows its setting": """
        from usdsdg.session.settings.store import get_settings
        get_settings().set("/omni/replicator/globalSeed", 7)
        from usdsdg.graph.sampling import get_global_seed
        print(get_global_seed() == 7)
    """,
    "settings of writing are obeyed": """
        from usdsdg.session.settings.store import get_settings
        get_settings().set("/omni/replicator/backend/queueSize", 7)
        get_settings().set("/omni/replicator/backends/disk/root_dir", "/some/folder")
        from usdsdg.writers.backends.disk import disk_root
        from usdsdg.backends import io_queue
        print(io_queue.max_jobs == 7 and str(disk_root()) == "/some/folder")
    """,
    "a stage gets its run when it is saved": """
        from usdsdg.create import cube
        from usdsdg.distribution import uniform
        from usdsdg.session.stage_context import current_stage, snapshot
        from pathlib import Path
        cube(position=uniform((0, 0, 0), (1, 1, 1)))
        layer = snapshot(Path.cwd())
        print(layer.GetAttributeAtPath("/Replicator/SDGPipeline.usdsdg:frames").default == 0)
    """,
    "a saved graph knows what its nodes do": """
        from usdsdg.graph.actions import action_of, load_actions
        load_actions()
        known = "OgnRotation OgnMass OgnWritePose OgnCarbSettings OgnWriteMaterialInputs".split()
        print(all(map(action_of, known)))
    """,
    "demo assets stand in for real ones": """
        from usdsdg.session.stage_context import assets_root
        import os
        print(os.path.isdir(assets_root()))
    """,
    "foreign names come first": """
        import usdsdg.compat
        usdsdg.compat.install()
        from omni.isaac.nucleus import get_assets_root_path
        import carb.settings, omni.timeline, omni.kit.app
        heard = []
        from carb.eventdispatcher import get_eventdispatcher
        held = get_eventdispatcher().observe_event(
            event_name=omni.timeline.GLOBAL_EVENT_STOP, on_event=lambda event: heard.append(event.event_name)
        )
        carb.settings.get_settings().set("/app/player/playSimulations", False)
        omni.timeline.get_timeline_interface().play()
        omni.kit.app.get_app().update()
        import omni.usd
        omni.usd.get_context().new_stage()
        print(bool(get_assets_root_path()) and heard == [omni.timeline.GLOBAL_EVENT_STOP])
    """,
    "the package alone": """
        import usdsdg as rep
        cube = rep.create.cube()
        with rep.trigger.on_frame():
            with cube:
                rep.randomizer.rotation()
        rep.orchestrator.step()
        print(rep.orchestrator.get_status().name == "STEPPED")
    """,
}


@pytest.mark.parametrize("name", sampled(SCRIPTS, 4))
def test_a_module_works_alone_in_a_fresh_process(name, tmp_path):
    command = [sys.executable, "-c", textwrap.dedent(SCRIPTS[name])]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "True"


@pytest.mark.parametrize("plays", sampled([True, False]))
def test_a_script_without_bodies_imports_neither_newton_nor_scipy(plays, tmp_path):
    script = f"""
        import sys
        import usdsdg as rep
        from usdsdg.session.timeline import get_timeline
        rep.create.light(light_type="Dome", intensity=1000)
        cube = rep.create.cube(semantics=[("class", "cube")])
        writer = rep.writers.get("BasicWriter")
        writer.initialize(
            output_dir={str(tmp_path)!r}, rgb=True, semantic_segmentation=True, bounding_box_3d=True,
            bounding_box_2d_tight=True, distance_to_camera=True, normals=True, occlusion=True, camera_params=True,
        )
        writer.attach(rep.create.render_product(rep.create.camera(position=(5, 5, 5), look_at=(0, 0, 0)), (16, 12)))
        with rep.trigger.on_frame(max_execs=3), cube:
            rep.modify.pose(rotation=rep.distribution.uniform((0, 0, 0), (360, 360, 360)))
        if {plays}:
            get_timeline().play()
        rep.orchestrator.run()
        print(not {{"newton", "scipy", "torch"}} & set(sys.modules))
    """
    command = [sys.executable, "-c", textwrap.dedent(script)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().splitlines()[-1] == "True"
    assert (tmp_path / "rgb_0002.png").exists()
