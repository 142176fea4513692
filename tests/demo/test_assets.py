"""Demo assets as USD: every URL of Isaac Sim's example, and what renderer and physics expect of an asset."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from usdsdg.demo import asset_urls, build

# As Isaac Sim's object-based example names them.
REFERENCE_URLS = [
    "/Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd",
    "/Isaac/Props/YCB/Axis_Aligned_Physics/006_mustard_bottle.usd",
    "/Isaac/Environments/Simple_Warehouse/Props/SM_CardBoxD_04_1847.usd",
    "/Isaac/Environments/Simple_Warehouse/Props/SM_CardBoxA_01_414.usd",
    "/Isaac/Environments/Simple_Warehouse/Props/S_TrafficCone.usd",
    "/Isaac/Environments/Simple_Warehouse/Props/S_WetFloorSign.usd",
    "/Isaac/Environments/Simple_Warehouse/Props/SM_BarelPlastic_B_03.usd",
    "/Isaac/Environments/Office/Props/SM_Board.usd",
    "/Isaac/Environments/Office/Props/SM_Book_03.usd",
    "/Isaac/Environments/Office/Props/SM_Book_34.usd",
    "/Isaac/Environments/Office/Props/SM_BookOpen_01.usd",
    "/Isaac/Environments/Office/Props/SM_Briefcase.usd",
    "/Isaac/Environments/Office/Props/SM_Extinguisher.usd",
    "/Isaac/Environments/Hospital/Props/SM_GasCart_01b.usd",
    "/Isaac/Environments/Hospital/Props/SM_MedicalBag_01a.usd",
    "/Isaac/Environments/Hospital/Props/SM_MedicalBox_01g.usd",
    "/Isaac/Environments/Hospital/Props/SM_Toweldispenser_01a.usd",
    "/NVIDIA/Assets/Skies/Indoor/autoshop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/carpentry_shop_01_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/hotel_room_4k.hdr",
    "/NVIDIA/Assets/Skies/Indoor/wooden_lounge_4k.hdr",
    "/Isaac/Environments/Simple_Warehouse/warehouse.usd",
    "/Isaac/Environments/Grid/default_environment.usd",
]

# Width, depth, height of the scanned YCB models in meters.
YCB_SIZES = {
    "003_cracker_box": (0.072, 0.164, 0.214),
    "004_sugar_box": (0.045, 0.092, 0.176),
    "005_tomato_soup_can": (0.068, 0.068, 0.102),
    "006_mustard_bottle": (0.096, 0.058, 0.191),
    "008_pudding_box": (0.090, 0.113, 0.038),
    "010_potted_meat_can": (0.102, 0.057, 0.083),
    "011_banana": (0.198, 0.069, 0.036),
    "035_power_drill": (0.184, 0.187, 0.057),
}

GROCERY_URLS = [
    f"{folder}/{name}" for name in asset_urls.GROCERIES for folder in (asset_urls.YCB, asset_urls.YCB_PHYSICS)
]
STAGES = [asset_urls.WAREHOUSE_STAGE, asset_urls.GRID_STAGE]
ALL_URLS = sorted([*GROCERY_URLS, *asset_urls.PROPS, *asset_urls.PANORAMAS, *STAGES])
ASSET_URLS = [url for url in ALL_URLS if url.endswith(".usd")]


@pytest.fixture(scope="module")
def root(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("demo")
    build.build(folder)
    return folder


def opened(root: Path, url: str) -> Usd.Stage:
    return Usd.Stage.Open(str(root / url.lstrip("/")))


def meshes(stage: Usd.Stage) -> list[UsdGeom.Mesh]:
    return [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]


def bounds(stage: Usd.Stage) -> tuple[np.ndarray, np.ndarray]:
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    box = cache.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    return np.array(box.GetMin()), np.array(box.GetMax())


@pytest.mark.parametrize("url", REFERENCE_URLS)
def test_every_url_of_the_example_has_a_file(root, url):
    assert (root / url.lstrip("/")).is_file()
    assert url in ALL_URLS


@pytest.mark.parametrize("url", ASSET_URLS)
def test_assets_open_without_errors_in_meters_with_z_up(root, url):
    stage = opened(root, url)
    assert stage.GetDefaultPrim()
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetCompositionErrors() == []
    assert meshes(stage)


@pytest.mark.parametrize("url", ASSET_URLS)
def test_meshes_are_complete(root, url):
    stage = opened(root, url)
    for mesh in meshes(stage):
        points = np.array(mesh.GetPointsAttr().Get())
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        normals = np.array(mesh.GetNormalsAttr().Get())
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        assert counts.min() >= 3
        assert len(indices) == counts.sum() == len(normals) == len(st.Get())
        assert 0 <= indices.min() <= indices.max() < len(points)
        assert mesh.GetNormalsInterpolation() == st.GetInterpolation() == "faceVarying"
        assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
        assert np.array(mesh.GetExtentAttr().Get()) == pytest.approx(np.stack([points.min(0), points.max(0)]))
        assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("url", ASSET_URLS)
def test_every_face_has_a_preview_surface_whose_texture_exists(root, url):
    stage = opened(root, url)
    for mesh in meshes(stage):
        subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
        if subsets:
            faces = len(mesh.GetFaceVertexCountsAttr().Get())
            assert UsdGeom.Subset.ValidateFamily(mesh, "face", "materialBind")[0]
            assert sum(len(subset.GetIndicesAttr().Get()) for subset in subsets) == faces
        for prim in [subset.GetPrim() for subset in subsets] or [mesh.GetPrim()]:
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            surface = material.ComputeSurfaceSource()[0]
            assert surface.GetIdAttr().Get() == "UsdPreviewSurface"
            color = surface.GetInput("diffuseColor")
            if color.HasConnectedSource():
                texture = UsdShade.Shader(color.GetConnectedSource()[0].GetPrim())
                asset = texture.GetInput("file").Get()
                assert asset.path.startswith("./")
                with Image.open(asset.resolvedPath) as image:
                    image.load()
                    assert min(image.size) >= 128


@pytest.mark.parametrize("name", YCB_SIZES)
def test_groceries_have_the_size_of_the_originals_around_the_origin(root, name):
    low, high = bounds(opened(root, f"{asset_urls.YCB}/{name}.usd"))
    assert high - low == pytest.approx(YCB_SIZES[name], rel=0.1)
    assert low + high == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("url", asset_urls.PROPS)
def test_props_stand_on_the_origin(root, url):
    low, high = bounds(opened(root, url))
    assert low[2] == pytest.approx(0.0, abs=1e-4)
    assert (low + high)[:2] == pytest.approx(0.0, abs=1e-4)
    assert 0.02 < (high - low).max() < 1.5


@pytest.mark.parametrize("name", asset_urls.GROCERIES)
def test_physics_variants_are_rigid_bodies_with_the_same_meshes(root, name):
    plain, physics = (opened(root, f"{folder}/{name}") for folder in (asset_urls.YCB, asset_urls.YCB_PHYSICS))
    body = physics.GetDefaultPrim()
    assert body.HasAPI(UsdPhysics.RigidBodyAPI)
    assert 0.05 < UsdPhysics.MassAPI(body).GetMassAttr().Get() < 1.0
    assert len(meshes(physics)) == len(meshes(plain))
    for mine, theirs in zip(meshes(physics), meshes(plain)):
        assert mine.GetPrim().HasAPI(UsdPhysics.CollisionAPI)
        assert UsdPhysics.MeshCollisionAPI(mine).GetApproximationAttr().Get() == "convexHull"
        assert np.array_equal(mine.GetPointsAttr().Get(), theirs.GetPointsAttr().Get())
    assert not any(mesh.GetPrim().HasAPI(UsdPhysics.CollisionAPI) for mesh in meshes(plain))


def test_the_warehouse_has_lamps_and_props_on_its_floor(root):
    stage = opened(root, asset_urls.WAREHOUSE_STAGE)
    low, _ = bounds(stage)
    assert sum(prim.GetTypeName() == "RectLight" for prim in stage.Traverse()) == 6
    assert len([p for p in stage.GetDefaultPrim().GetChildren() if p.HasAuthoredReferences()]) > 10
    assert low[2] == pytest.approx(-0.1, abs=0.01)


def test_the_grid_collides_below_everything_and_has_a_line_at_each_meter(root):
    stage = opened(root, asset_urls.GRID_STAGE)
    plane = stage.GetDefaultPrim().GetPrimAtPath("GroundPlane/CollisionPlane")
    assert plane.IsA(UsdGeom.Plane)
    assert plane.HasAPI(UsdPhysics.CollisionAPI)
    low, high = bounds(stage)
    assert low == pytest.approx((-50, -50, 0))
    assert high[:2] == pytest.approx((50, 50))
    texture = np.asarray(Image.open(next((root / "Isaac/Environments/Grid/textures").iterdir())), float).mean(2)
    bright = texture[50] > texture[50].min() + 20
    assert np.flatnonzero(np.diff(bright.astype(int)) == 1).size == 9  # and one at the edge
