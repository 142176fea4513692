"""`World().scene.add_default_ground_plane()`, with every kind of assets root."""

import warnings

import pytest
from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.api import World, objects
from usdsdg.demo.asset_urls import GRID_STAGE
from usdsdg.demo.props.grid_environment import write_grid
from usdsdg.errors import BadPrim, UsdsdgWarning
from usdsdg.stage import assets


@pytest.fixture
def world(stage):
    made = World()
    yield made
    World.clear_instance()


@pytest.fixture
def root(tmp_path, monkeypatch):
    """An empty assets root, and an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "assets"
    (folder / GRID_STAGE.lstrip("/")).parent.mkdir(parents=True)
    before = assets.configured_root()
    assets.set_assets_root(folder)
    yield folder
    assets.set_assets_root(before)


def lands_on(world):
    """Return the height at which a cube of 0.2 m comes to rest."""
    cube = world.scene.add(objects.DynamicCuboid("/World/cube", position=(0, 0, 0.5), size=0.2))
    world.reset()
    for _ in range(90):
        world.step(render=False)
    return cube.get_world_pose()[0][2]


@pytest.mark.parametrize("on_missing", assets.OnMissing)
def test_the_demo_grid_stands_in_where_the_root_has_none(world, root, on_missing):
    assets.set_on_missing(on_missing)
    with pytest.warns(UsdsdgWarning, match=f"demo assets stands in .*: no file for {GRID_STAGE}"):
        ground = world.scene.add_default_ground_plane()
    assert ground.collision_geometry_prim.prim_path == "/World/defaultGroundPlane/GroundPlane/CollisionPlane"
    assert lands_on(world) == pytest.approx(0.1, abs=2e-3)
    assets.check_missing(world.stage)


def test_a_grid_of_the_root_is_taken(world, root):
    write_grid(root / GRID_STAGE.lstrip("/"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.scene.add_default_ground_plane(z_position=-1.0)
    assert world.stage.GetPrimAtPath("/World/defaultGroundPlane/Floor").IsA(UsdGeom.Mesh)
    assert lands_on(world) == pytest.approx(-0.9, abs=2e-3)


@pytest.mark.parametrize("collides", [True, False])
def test_a_mesh_may_be_the_ground(world, root, collides):
    file = Usd.Stage.CreateNew(str(root / GRID_STAGE.lstrip("/")))
    file.SetDefaultPrim(file.DefinePrim("/Root", "Xform"))
    for name in ("Sign", "Ground"):
        mesh = UsdGeom.Mesh.Define(file, f"/Root/{name}")
        mesh.CreatePointsAttr([(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)])
        mesh.CreateFaceVertexCountsAttr([4])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    if collides:
        UsdPhysics.CollisionAPI.Apply(file.GetPrimAtPath("/Root/Ground"))
    file.Save()
    ground = world.scene.add_default_ground_plane()
    expected = "Ground" if collides else "Sign"
    assert ground.collision_geometry_prim.prim_path == f"/World/defaultGroundPlane/{expected}"
    assert lands_on(world) == pytest.approx(0.1, abs=2e-3)


def test_a_prim_without_geometry_is_no_ground(world):
    world.stage.DefinePrim("/World/nothing", "Xform")
    with pytest.raises(BadPrim, match="neither a Plane nor a Mesh"):
        objects.GroundPlane("/World/nothing")
