"""The behaviors: what they expose, what they change while the timeline plays, and that stop undoes it."""

import inspect
import itertools

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdPhysics, UsdShade

from usdsdg.app.app import get_app
from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.isaacsim.replicator.behavior import behaviors
from usdsdg.compat.isaacsim.replicator.behavior.utils import behavior_utils, scene_utils
from usdsdg.compat.omni.behavior.scripting import core
from usdsdg.compat.omni.behavior.scripting.core import get_script_manager
from usdsdg.compat.omni.kit.commands import execute
from usdsdg.session.timeline import get_timeline


def _attach(prim, behavior: type, **variables):
    behavior_utils.add_behavior_script(prim, inspect.getfile(behavior))
    get_app().update()
    names = {f"exposedVar:{behavior.BEHAVIOR_NS}:{name.replace('__', ':')}": v for name, v in variables.items()}
    assert all(prim.HasAttribute(name) for name in names)
    behavior_utils.set_exposed_variables(prim, names)


def _translation(prim):
    return np.array(UsdGeom.Xformable(prim).GetLocalTransformation().ExtractTranslation())


def test_location_is_drawn_around_where_the_prim_was(stage):
    prim = stage.DefinePrim("/World/A", "Cube")
    UsdGeom.Xformable(prim).AddTranslateOp().Set((10, 0, 0))
    _attach(prim, behaviors.LocationRandomizer, range__minPosition=(0, 1, 2), range__maxPosition=(0, 1, 3), seed=7)
    get_timeline().play()
    get_app().update()
    rng = np.random.default_rng(7)
    expected = [10 + rng.uniform(0, 0), rng.uniform(1, 1), rng.uniform(2, 3)]
    assert _translation(prim) == pytest.approx(expected)
    get_timeline().stop()
    assert _translation(prim) == pytest.approx([10, 0, 0])


def test_location_follows_another_prim(stage):
    target = stage.DefinePrim("/World/Target", "Cube")
    move = UsdGeom.Xformable(target).AddTranslateOp()
    prim = stage.DefinePrim("/World/A", "Cube")
    UsdGeom.Xformable(prim).AddTranslateOp().Set((1, 0, 0))
    none = Gf.Vec3d(0)
    _attach(
        prim,
        behaviors.LocationRandomizer,
        range__minPosition=none,
        range__maxPosition=none,
        frame__targetPrimPath="/World/Target",
    )
    get_timeline().play()
    move.Set((0, 5, 0))
    get_app().update()
    assert _translation(prim) == pytest.approx([1, 5, 0])


@pytest.mark.parametrize(("include", "moved"), [(True, True), (False, False)])
def test_children_are_included_unless_the_variable_says_no(stage, include, moved):
    root, child = stage.DefinePrim("/World/R", "Xform"), stage.DefinePrim("/World/R/C", "Cube")
    _attach(root, behaviors.LocationRandomizer, includeChildren=include)
    get_timeline().play()
    get_app().update()
    assert bool(_translation(root).any())
    assert bool(_translation(child).any()) is moved


def test_an_interval_changes_prims_at_once_and_then_at_every_nth_update(stage):
    prim = stage.DefinePrim("/World/A", "Cube")
    _attach(prim, behaviors.LocationRandomizer, interval=3)
    get_timeline().play()
    seen = [tuple(_translation(prim))]
    for _ in range(6):
        get_app().update()
        seen.append(tuple(_translation(prim)))
    changes = [before != after for before, after in itertools.pairwise(seen)]
    assert any(seen[0])
    assert changes == [False, False, True, False, False, True]


def test_rotation_composes_x_then_y_then_z(stage):
    prim = stage.DefinePrim("/World/A", "Cube")
    fixed = Gf.Vec3d(30, 40, 50)
    _attach(prim, behaviors.RotationRandomizer, range__minRotation=fixed, range__maxRotation=fixed)
    get_timeline().play()
    get_app().update()
    # A rotateXYZ op is the independent definition of that order.
    other = UsdGeom.Xformable(stage.DefinePrim("/World/Other", "Cube"))
    other.AddRotateXYZOp().Set(Gf.Vec3f(fixed))
    drawn = UsdGeom.Xformable(prim).GetLocalTransformation()
    assert np.allclose(drawn, other.GetLocalTransformation(), atol=1e-6)
    get_timeline().stop()
    assert prim.GetAttribute("xformOp:orient").Get() == Gf.Quatd(1)


def test_a_light_gets_back_its_color_and_intensity(stage):
    light = stage.DefinePrim("/World/L", "SphereLight")
    light.GetAttribute("inputs:intensity").Set(5.0)
    _attach(light, behaviors.LightRandomizer, range__intensity=(100, 200))
    get_timeline().play()
    get_app().update()
    assert 100 <= light.GetAttribute("inputs:intensity").Get() <= 200
    assert all(0.1 <= c <= 0.9 for c in light.GetAttribute("inputs:color").Get())
    get_timeline().stop()
    assert light.GetAttribute("inputs:intensity").Get() == 5.0
    assert light.GetAttribute("inputs:color").Get() == Gf.Vec3f(1)


def test_a_camera_looks_at_its_target(stage):
    camera = stage.DefinePrim("/World/C", "Camera")
    UsdGeom.Xformable(camera).AddTranslateOp().Set((3, 4, 5))
    _attach(camera, behaviors.LookAtBehavior, targetLocation=(1, 1, 1))
    get_timeline().play()
    get_app().update()
    to_world = UsdGeom.Xformable(camera).GetLocalTransformation()
    view = to_world.TransformDir(Gf.Vec3d(0, 0, -1))
    assert np.allclose(view, (Gf.Vec3d(1, 1, 1) - Gf.Vec3d(3, 4, 5)).GetNormalized())
    assert to_world.TransformDir(Gf.Vec3d(1, 0, 0))[2] == pytest.approx(0)  # the horizon is level


def test_textures_are_drawn_for_materials_that_stop_removes(stage):
    cube = stage.DefinePrim("/World/A", "Cube")
    own = UsdShade.Material.Define(stage, "/World/Own")
    UsdShade.MaterialBindingAPI.Apply(cube).Bind(own)
    _attach(cube, behaviors.TextureRandomizer, textures__csv="file:///a.png,file:///b.png", projectUvwProbability=1.0)
    get_timeline().play()
    get_app().update()
    bound, _ = UsdShade.MaterialBindingAPI(cube).ComputeBoundMaterial()
    shader = UsdShade.Shader(bound.GetPrim().GetChild("Shader"))
    assert shader.GetInput("diffuse_texture").Get().path in ("file:///a.png", "file:///b.png")
    assert shader.GetInput("project_uvw").Get() is True
    assert 0 <= shader.GetInput("texture_rotate").Get() <= 45
    get_timeline().stop()
    assert UsdShade.MaterialBindingAPI(cube).ComputeBoundMaterial()[0].GetPath() == own.GetPath()
    assert not stage.GetPrimAtPath("/Behaviors")


def test_draws_follow_the_global_seed(stage):
    from usdsdg.graph.sampling import set_global_seed

    prim = stage.DefinePrim("/World/A", "Cube")
    _attach(prim, behaviors.LocationRandomizer)

    def drawn(seed: int) -> tuple:
        set_global_seed(seed)
        get_timeline().play()
        get_app().update()
        found = tuple(_translation(prim))
        get_timeline().stop()
        return found

    assert drawn(3) == drawn(3) != drawn(4)


def test_variables_go_with_the_script(stage):
    prim = stage.DefinePrim("/World/A", "Cube")
    _attach(prim, behaviors.LocationRandomizer)
    prim.GetAttribute("omni:scripting:scripts").Set(Sdf.AssetPathArray())
    get_app().update()
    assert not [name for name in prim.GetPropertyNames() if name.startswith("exposedVar")]


@pytest.mark.parametrize(
    ("apply", "remove"),
    [
        (
            lambda: core.ApplyScriptingAPICommand(paths=["/World/A"]).do(),
            lambda: core.RemoveScriptingAPICommand(paths=["/World/A"]).do(),
        ),
        (
            lambda: execute("ApplyScriptingAPICommand", paths=[Sdf.Path("/World/A")]),
            lambda: execute("RemoveScriptingAPICommand", paths=[Sdf.Path("/World/A")]),
        ),
    ],
)
def test_commands_let_a_prim_name_its_scripts(stage, apply, remove):
    prim = stage.DefinePrim("/World/A", "Cube")
    apply()
    assert "OmniScriptingAPI" in prim.GetMetadata("apiSchemas").GetAddedOrExplicitItems()
    file = inspect.getfile(behaviors.LocationRandomizer)
    prim.GetAttribute("omni:scripting:scripts").Set(Sdf.AssetPathArray([file]))
    get_app().update()
    assert [name for name in prim.GetPropertyNames() if name.startswith("exposedVar")]
    remove()
    get_app().update()
    assert not prim.HasAttribute("omni:scripting:scripts")
    assert "OmniScriptingAPI" not in prim.GetMetadata("apiSchemas").GetAddedOrExplicitItems()


def test_parameters_are_set_when_the_script_has_exposed_them(stage):
    prim = stage.DefinePrim("/World/A", "Cube")
    get_app().run_until_complete(
        behavior_utils.add_behavior_script_with_parameters_async(
            prim, inspect.getfile(behaviors.LocationRandomizer), {"exposedVar:locationRandomizer:interval": 4}
        )
    )
    assert prim.GetAttribute("exposedVar:locationRandomizer:interval").Get() == 4


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_rotations_survive_every_rotate_op(stage, order):
    rotation = Gf.Rotation(Gf.Vec3d(1, 2, 3), 77)
    prim = stage.DefinePrim("/World/A", "Xform")
    kind = getattr(UsdGeom.XformOp, f"TypeRotate{order}")
    UsdGeom.Xformable(prim).AddXformOp(kind)
    scene_utils.set_rotation_with_ops(prim, rotation)
    found = UsdGeom.Xformable(prim).GetLocalTransformation()
    assert np.allclose(found, Gf.Matrix4d().SetRotate(rotation), atol=1e-6)


def test_a_stack_is_dropped_into_the_walls_and_stays(stage, tmp_path):
    from pxr import Usd

    asset = Usd.Stage.CreateNew(str(tmp_path / "box.usda"))
    UsdGeom.SetStageUpAxis(asset, "Z")
    cube = UsdGeom.Cube.Define(asset, "/Box/Cube")
    cube.CreateSizeAttr(0.2)
    asset.SetDefaultPrim(asset.GetPrimAtPath("/Box"))
    asset.Save()
    table = stage.DefinePrim("/World/Table", "Cube")
    UsdGeom.Xformable(table).AddTranslateOp().Set((5, 0, 1))
    UsdGeom.Xformable(table).AddScaleOp().Set((0.5, 0.5, 0.1))
    UsdPhysics.CollisionAPI.Apply(table)
    _attach(
        table,
        behaviors.VolumeStackRandomizer,
        assets__csv=str(tmp_path / "box.usda").join(("file://", "")),
        assets__numRange=Gf.Vec2i(2, 2),
        dropHeight=0.5,
        renderSimulation=False,
        seed=1,
    )
    states = []
    out = behaviors.VolumeStackRandomizer.EVENT_NAME_OUT
    observer = get_eventdispatcher().observe_event(event_name=out, on_event=lambda e: states.append(e["state_name"]))

    async def act(action: str, state: str) -> None:
        done = await behavior_utils.publish_event_and_wait_for_completion_async(
            {"prim_path": "/World/Table", "action": action},
            {"prim_path": "/World/Table", "state_name": state},
            behaviors.VolumeStackRandomizer.EVENT_NAME_IN,
            out,
            50,
            verbose=False,
        )
        assert done

    get_app().run_until_complete(act("setup", "SETUP"))
    scope = "/Behaviors/volumeStackRandomizer"
    assert len(stage.GetPrimAtPath(f"{scope}/Assets/Table").GetChildren()) == 2
    assert len(stage.GetPrimAtPath(f"{scope}/CollisionWalls/Table/CollisionWalls").GetChildren()) == 6
    get_app().run_until_complete(act("run", "FINISHED"))
    boxes = stage.GetPrimAtPath(f"{scope}/Assets/Table").GetChildren()
    at = np.array([_translation(box) for box in boxes])
    assert (np.abs(at[:, :2] - [5, 0]) < 0.5).all()
    assert (at[:, 2] > 1.15).all()
    assert (at[:, 2] < 1.6).all()
    assert not stage.GetPrimAtPath(f"{scope}/CollisionWalls")
    get_app().run_until_complete(act("reset", "RESET"))
    assert not stage.GetPrimAtPath("/Behaviors")
    assert states == ["SETUP", "RUNNING", "FINISHED", "RESET"]
    observer.reset()
    assert len(get_script_manager().scripts("/World/Table")) == 1
