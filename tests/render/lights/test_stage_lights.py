"""UsdLux lights of a stage under any transform: irradiance matches the integral over their world-space surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from tests.render import scenes
from tests.render.images import EXACT
from tests.render.lights import light_oracle
from tests.render.materials.test_materials import Looks, T
from tests.sampled_cases import crossed
from usdsdg.stage.poses.transforms import local_to_world
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.settings import PathSettings

ALBEDO = 0.5
# (prim, shape of the oracle, its size, UsdLux's inputs): all emit toward -z, cylinders lie along x.
KINDS = {
    "SphereLight": ("ellipsoid", dict(axes=(0.4, 0.4, 0.4)), dict(radius=0.4)),
    "RectLight": ("rect", dict(width=1.5, height=0.5), dict(width=1.5, height=0.5)),
    "DiskLight": ("disk", dict(axes=(0.6, 0.6)), dict(radius=0.6)),
    "CylinderLight": ("cylinder", dict(axes=(0.2, 0.2), length=1.8), dict(radius=0.2, length=1.8)),
}
SCALES = {
    "even": (1.0, 1.0, 1.0),
    "larger": (1.7, 1.7, 1.7),
    "stretched": (0.6, 1.8, 1.2),
    "mirrored": (-0.8, 1.3, 0.9),
}


def floor_stage() -> Usd.Stage:
    looks = Looks()
    looks.set("diffuseColor", T.Color3f, Gf.Vec3f(ALBEDO))
    looks.set("ior", T.Float, 1.0)
    looks.set("roughness", T.Float, 1.0)
    stage = looks.stage
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    floor = UsdGeom.Mesh.Define(stage, "/Floor")
    floor.CreatePointsAttr([Gf.Vec3f(x, y, 0) for x, y in ((-500, -500), (500, -500), (500, 500), (-500, 500))])
    floor.CreateFaceVertexCountsAttr([4])
    floor.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    floor.CreateSubdivisionSchemeAttr("none")
    floor.GetPrim().ApplyAPI("MaterialBindingAPI")
    floor.GetPrim().CreateRelationship("material:binding").SetTargets([looks.material.GetPath()])
    return stage


def floor_irradiance(stage: Usd.Stage, samples: int) -> float:
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    film = renderer.new_film(1, 1)
    view = scenes.view_from((0.0, -6.0, 0.3), size=(1, 1), focal_length=50000.0)
    renderer.accumulate(film, view, samples=samples, settings=PathSettings(bounces=1, **EXACT))
    return float(film.radiance().mean() * np.pi / ALBEDO)


@pytest.mark.parametrize(("normalize", "scale"), crossed([False, True], SCALES))
@pytest.mark.parametrize("kind", KINDS)
def test_irradiance_on_a_floor_matches_the_surface_integral_of_the_light(kind, scale, normalize):
    shape, size, inputs = KINDS[kind]
    stage = floor_stage()
    light = UsdLux.BoundableLightBase(stage.DefinePrim("/Light", kind))
    for name, value in inputs.items():
        light.GetPrim().GetAttribute(f"inputs:{name}").Set(value)
    light.CreateIntensityAttr(60.0)
    light.CreateExposureAttr(1.0)
    light.CreateNormalizeAttr(normalize)
    xform = UsdGeom.Xformable(light)
    xform.AddTranslateOp().Set(Gf.Vec3d(0.7, -0.4, 2.2))
    xform.AddRotateXYZOp().Set(Gf.Vec3f(25, -35, 50))
    xform.AddScaleOp().Set(Gf.Vec3f(*SCALES[scale]))
    matrix = np.array(local_to_world(light.GetPrim()))
    points, areas = light_oracle.patches(shape, **size)
    turn = matrix[:3, :3]
    # Areas transform by the cofactors; outward normals stay outward under reflection.
    areas = areas @ np.linalg.inv(turn).T * abs(np.linalg.det(turn))
    radiance = 120.0 / (np.linalg.norm(areas, axis=1).sum() if normalize else 1.0)
    expected = light_oracle.irradiance(points @ turn + matrix[3, :3], areas, radiance)
    assert expected > 1.0
    np.testing.assert_allclose(floor_irradiance(stage, 8192), expected, rtol=0.015)


@pytest.mark.parametrize("scale", SCALES)
def test_irradiance_of_a_mesh_light_matches_lamberts_formula(scale):
    stage = floor_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/Lamp")
    corners = np.array([(-0.8, -0.5, 0), (0.9, -0.4, 0.2), (0.1, 0.7, -0.1)])
    mesh.CreatePointsAttr([Gf.Vec3f(*map(float, corner)) for corner in corners])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreateSubdivisionSchemeAttr("none")
    light = UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    UsdLux.LightAPI(light).CreateIntensityAttr(60.0)
    xform = UsdGeom.Xformable(mesh)
    xform.AddTranslateOp().Set(Gf.Vec3d(0.7, -0.4, 2.2))
    xform.AddRotateXYZOp().Set(Gf.Vec3f(25, -35, 50))
    xform.AddScaleOp().Set(Gf.Vec3f(*SCALES[scale]))
    matrix = np.array(local_to_world(mesh.GetPrim()))
    expected = 60.0 * light_oracle.lambert_polygon(corners @ matrix[:3, :3] + matrix[3, :3])
    np.testing.assert_allclose(floor_irradiance(stage, 4096), expected, rtol=0.015)
