"""UsdGeom shapes: on the analytic surface, closed, facing out, of the analytic area and volume."""

import math

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from usdsdg_render.geometry import shapes
from usdsdg_render.usd.prim_kinds import SHAPE_PARAMETERS

CLOSED = [
    ("Cube", (3.0,)),
    ("Sphere", (1.5,)),
    ("Cylinder", (0.5, 3.0)),
    ("Cylinder_1", (0.7, 0.3, 2.0)),
    ("Cylinder_1", (0.0, 0.3, 2.0)),
    ("Cone", (0.8, 2.5)),
    ("Capsule", (0.4, 1.2)),
    ("Capsule", (0.4, 0.0)),
    ("Capsule_1", (0.5, 0.2, 1.0)),
    ("Capsule_1", (0.1, 0.6, 1.0)),
    ("Capsule_1", (0.5, 0.0, 1.0)),
    ("Capsule_1", (0.5, 0.1, 0.2)),
]
AXIS_TO_Z = {"X": [1, 2, 0], "Y": [2, 0, 1], "Z": [0, 1, 2]}


def area_vectors(surface):
    a, b, c = surface.points[surface.triangles].astype(np.float64).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2.0


def area(surface):
    return np.linalg.norm(area_vectors(surface), axis=1).sum()


def volume(surface):
    return np.einsum("ij,ij->", surface.points[surface.triangles[:, 0]].astype(np.float64), area_vectors(surface)) / 3.0


@pytest.mark.parametrize("axis", "XYZ")
@pytest.mark.parametrize(("kind", "values"), CLOSED)
def test_closed_shapes_are_watertight_and_face_out(kind, values, axis):
    surface = shapes.tessellate((kind, axis, values))
    directed = surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert len(np.unique(directed, axis=0)) == len(directed), "an edge is walked twice in one direction"
    edges = np.unique(np.sort(directed, axis=1), axis=0)
    assert len(edges) * 2 == len(directed)
    assert len(surface.points) - len(edges) + len(surface.triangles) == 2
    assert volume(surface) > 0.0
    assert (np.linalg.norm(area_vectors(surface), axis=1) > 0.0).all()


@pytest.mark.parametrize(("kind", "values"), [*CLOSED, ("Plane", (2.0, 3.0))])
def test_normals_are_unit_and_agree_with_the_winding(kind, values):
    surface = shapes.tessellate((kind, "Y", values))
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=-1), 1.0, atol=1e-6)
    facing = np.einsum("tci,ti->tc", surface.normals, area_vectors(surface))
    assert (facing > 0.0).all()


@pytest.mark.parametrize(
    ("kind", "values", "true_area", "true_volume"),
    [
        ("Cube", (3.0,), 54.0, 27.0),
        ("Sphere", (1.5,), 9.0 * math.pi, 4.5 * math.pi),
        ("Cylinder", (0.5, 3.0), 3.5 * math.pi, 0.75 * math.pi),
        ("Cone", (0.8, 2.5), math.pi * 0.8 * (0.8 + math.hypot(0.8, 2.5)), math.pi * 0.64 * 2.5 / 3.0),
        ("Capsule", (0.4, 1.2), math.pi * 0.8 * 2.0, math.pi * (0.16 * 1.2 + 4.0 / 3.0 * 0.064)),
    ],
)
def test_area_and_volume_approach_the_analytic_ones_from_below(kind, values, true_area, true_volume):
    # A circle of n segments has an area of 1 - 2 pi^2 / (3 n^2), 0.9984 for 64; rings from pole to pole lose as much.
    surface = shapes.tessellate((kind, "Z", values))
    assert 0.995 * true_area < area(surface) <= true_area * (1 + 1e-6)
    assert 0.993 * true_volume < volume(surface) <= true_volume * (1 + 1e-6)


@pytest.mark.parametrize("axis", "XYZ")
def test_vertices_lie_on_the_analytic_surface(axis):
    def along_z(kind, *values):
        return shapes.tessellate((kind, axis, values)).points[:, AXIS_TO_Z[axis]].astype(np.float64)

    np.testing.assert_allclose(np.linalg.norm(along_z("Sphere", 1.5), axis=1), 1.5, rtol=1e-6)
    x, y, z = along_z("Capsule", 0.4, 1.2).T
    np.testing.assert_allclose(np.sqrt(x**2 + y**2 + (z - np.clip(z, -0.6, 0.6)) ** 2), 0.4, rtol=1e-6)
    x, y, z = along_z("Cone", 0.8, 2.5).T
    side = np.hypot(x, y) > 0
    np.testing.assert_allclose(np.hypot(x, y)[side], 0.8 * (1.25 - z[side]) / 2.5, atol=1e-6)
    assert z.max() == 1.25


def test_size_matches_the_extent_that_usd_computes():
    stage = Usd.Stage.CreateInMemory()
    for kind in SHAPE_PARAMETERS:
        for axis in "XYZ":
            prim = stage.DefinePrim(f"/{kind}_{axis}", kind)
            if prim.HasAttribute("axis"):
                prim.GetAttribute("axis").Set(axis)
            for k, name in enumerate(SHAPE_PARAMETERS[kind]):
                prim.GetAttribute(name).Set(1.0 + 0.5 * k)
            key = shapes.shape_key(prim, Usd.TimeCode.Default())
            assert key is not None
            points = shapes.tessellate(key).points
            extent = np.array(
                UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), Usd.TimeCode.Default())
            )
            # The widest circle of a tapered capsule lies between two rings.
            slack = 0.006 if kind == "Capsule_1" else 1e-6
            np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], extent, atol=slack)
            along = "XYZ".index(axis)
            np.testing.assert_allclose(
                [points.min(axis=0)[along], points.max(axis=0)[along]], extent[:, along], atol=1e-6
            )


def test_uvs_stay_in_the_unit_square_and_v_goes_up():
    for kind, values in CLOSED:
        surface = shapes.tessellate((kind, "Z", values))
        assert surface.uvs.min() >= -1e-6
        assert surface.uvs.max() <= 1.0 + 1e-6
    sphere = shapes.tessellate(("Sphere", "Z", (1.0,)))
    z = sphere.points[sphere.triangles][..., 2]
    np.testing.assert_allclose(sphere.uvs[..., 1], np.arcsin(np.clip(z, -1, 1)) / math.pi + 0.5, atol=1e-3)


@pytest.mark.parametrize("kind", ["Cube", "Sphere", "Cylinder", "Capsule"])
def test_images_are_not_mirrored(kind):
    """Where u and v grow, seen from outside, v is a quarter turn counter-clockwise of u."""
    surface = shapes.tessellate((kind, "Z", tuple(SHAPE_PARAMETERS[kind].values())))
    a, b, c = surface.uvs.astype(np.float64).transpose(1, 0, 2)
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (doubled > -1e-9).all()


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_shapes_without_a_surface_are_named(bad):
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Sphere.Define(stage, "/Ball").GetPrim()
    prim.GetAttribute("radius").Set(bad)
    with pytest.warns(UserWarning, match="Ball"):
        assert shapes.shape_key(prim, Usd.TimeCode.Default()) is None
