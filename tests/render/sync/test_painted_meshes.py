"""Other texture coordinates or colors of a mesh: read without its triangles, and with the values of a fresh reading."""

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from usdsdg_render.bvh import acceleration_structure
from usdsdg_render.device import device_scene
from usdsdg_render.geometry import meshes, prototypes
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.scene import Prototype

SIDE = 5  # faces along a side of a mesh
POINTS, CORNERS = (SIDE + 1) ** 2, 4 * SIDE**2
ARRAYS = ("points", "triangles", "normals", "uvs", "triangle_slots", "triangle_faces", "colors", "corners")
PLAIN, SUBDIVIDED = ("/World/Plain", "/World/Bent", "/World/Torn", "/World/Parted"), "/World/Subdivided"


def add_mesh(stage, path, rng, height=0.3):
    """A rough square of quads."""
    x, y = np.meshgrid(np.arange(SIDE + 1.0), np.arange(SIDE + 1.0))
    points = np.stack([x, y, height * rng.random(x.shape)], -1).reshape(-1, 3)
    first = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    faces = np.stack([first, first + 1, first + SIDE + 2, first + SIDE + 1], 1)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(faces.ravel().tolist())
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


@pytest.fixture
def stage():
    stage = Usd.Stage.CreateInMemory()
    rng = np.random.default_rng(1)
    for path in PLAIN:
        add_mesh(stage, path, rng)
    UsdGeom.Mesh.Get(stage, PLAIN[1]).CreateOrientationAttr("leftHanded")
    torn = UsdGeom.Mesh.Get(stage, PLAIN[2]).GetPointsAttr()
    torn.Set([Gf.Vec3f(float("nan")) if k == 7 else point for k, point in enumerate(torn.Get())])
    parted = UsdGeom.Mesh.Get(stage, PLAIN[3])
    for k, faces in enumerate(([0, 1, 2], [5, 6])):
        material = UsdShade.Material.Define(stage, f"/World/Looks/Look{k}")
        subset = UsdShade.MaterialBindingAPI.Apply(parted.GetPrim()).CreateMaterialBindSubset(f"part{k}", faces)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
    bent = add_mesh(stage, SUBDIVIDED, rng)
    bent.CreateSubdivisionSchemeAttr("catmullClark")
    bent.CreateCreaseIndicesAttr([0, 1])
    bent.CreateCreaseLengthsAttr([2])
    bent.CreateCreaseSharpnessesAttr([3.0])
    for k, path in enumerate((*PLAIN, SUBDIVIDED)):
        paint(stage, path, k)
    return stage


def paint(stage, path, k, count=POINTS, interpolation="vertex"):
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(path))
    made = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, interpolation)
    made.Set(Vt.Vec2fArray.FromNumpy(np.random.default_rng(k).random((count, 2)).astype(np.float32)))
    return made


def color(stage, path, k, count=POINTS, interpolation="vertex"):
    made = UsdGeom.Gprim(stage.GetPrimAtPath(path)).CreateDisplayColorPrimvar(interpolation)
    made.Set(Vt.Vec3fArray.FromNumpy(np.random.default_rng(k).random((count, 3)).astype(np.float32)))


def indexed(stage, path, k):
    rng = np.random.default_rng(k)
    made = paint(stage, path, k, 9, "faceVarying")
    made.SetIndices(Vt.IntArray.FromNumpy(rng.integers(0, 9, CORNERS).astype(np.int32)))


EDITS = {
    "other values": paint,
    "a value a corner": lambda *edit: paint(*edit, CORNERS, "faceVarying"),
    "a value a face": lambda *edit: paint(*edit, SIDE**2, "uniform"),
    "indices": indexed,
    "too few": lambda *edit: paint(*edit, 3),
    "none": lambda stage, path, _: stage.GetPrimAtPath(path).RemoveProperty("primvars:st"),
    "colors of points": color,
    "colors of faces": lambda *edit: color(*edit, SIDE**2, "uniform"),
    "colors of corners": lambda *edit: color(*edit, CORNERS, "faceVarying"),
}


def drawn(renderer) -> dict[str, Prototype]:
    scene = renderer._extractor.scene
    return {path: scene.prototypes[k] for path, k in zip(scene.instances.paths, scene.instances.prototype.tolist())}


def assert_fresh(renderer, stage):
    again = WarpRenderer(stage, device="cpu")
    again.sync()
    ours, theirs = drawn(renderer), drawn(again)
    assert ours.keys() == theirs.keys() == {*PLAIN, SUBDIVIDED}
    for path in ours:
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(ours[path], name), getattr(theirs[path], name), err_msg=name)


@pytest.mark.filterwarnings("ignore::usdsdg.errors.UsdsdgWarning")
@pytest.mark.parametrize("name", EDITS)
def test_other_paint_is_that_of_a_fresh_reading_and_makes_no_other_triangles(name, stage, monkeypatch):
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    triangulated, built = [], []
    triangulate, blas = meshes.triangulate, acceleration_structure.Blas
    for k in range(3):
        with monkeypatch.context() as patched:
            patched.setattr(meshes, "triangulate", lambda *given: triangulated.append(1) or triangulate(*given))
            patched.setattr(device_scene, "Blas", lambda *given: built.append(1) or blas(*given))
            for path in (*PLAIN, SUBDIVIDED):
                EDITS[name](stage, path, 20 + k)
            renderer.sync()
        assert_fresh(renderer, stage)
    # Those of the subdivided surface, whose texture coordinates are refined with it.
    assert len(triangulated) <= 3
    assert len(built) <= 3


def test_arrays_of_meshes_that_have_been_dropped_are_dropped(stage, monkeypatch):
    monkeypatch.setattr(prototypes, "MAX_IDLE_TRIANGLES", 5_000)
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    cache = renderer._extractor._prototypes
    for k in range(40):
        for path in PLAIN:
            paint(stage, path, k)
        points = UsdGeom.Mesh.Get(stage, PLAIN[0]).GetPointsAttr()
        points.Set([point + Gf.Vec3f(0, 0, 0.01) for point in points.Get()])
        renderer.sync()
        assert max(len(cache._paintable), len(cache._unpainted_content)) < 20
        assert {*map(id, drawn(renderer).values())} <= {*cache._recent}
    assert_fresh(renderer, stage)
