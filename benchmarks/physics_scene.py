"""The object-based scene of 337 bodies in a closed box: milliseconds per step, bodies that escape, speeds at rest.

    python benchmarks/physics_scene.py [--seconds 10] [--device cpu] [--all-gravity] [--bodies 337]

With USDSDG_ASSETS_ROOT set, bodies are the assets of the reference configuration; otherwise generated meshes.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import time

import numpy as np
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg_physics import NewtonEngine

AREA = (5.0, 5.0, 3.0)
LABELED = (
    "Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd",
    "Isaac/Props/YCB/Axis_Aligned_Physics/006_mustard_bottle.usd",
)
DISTRACTORS = (
    "Simple_Warehouse/Props/SM_CardBoxD_04_1847",
    "Simple_Warehouse/Props/SM_CardBoxA_01_414",
    "Simple_Warehouse/Props/S_TrafficCone",
    "Simple_Warehouse/Props/S_WetFloorSign",
    "Simple_Warehouse/Props/SM_BarelPlastic_B_03",
    "Office/Props/SM_Board",
    "Office/Props/SM_Book_03",
    "Office/Props/SM_Book_34",
    "Office/Props/SM_BookOpen_01",
    "Office/Props/SM_Briefcase",
    "Office/Props/SM_Extinguisher",
    "Hospital/Props/SM_GasCart_01b",
    "Hospital/Props/SM_MedicalBag_01a",
    "Hospital/Props/SM_MedicalBox_01g",
    "Hospital/Props/SM_Toweldispenser_01a",
)


def generated_meshes() -> list[trimesh.Trimesh]:
    """Return fifteen slightly irregular meshes of 0.3 to 0.8 m with 700 to 5,000 triangles."""
    rng = np.random.default_rng(7)
    kinds = [
        trimesh.creation.icosphere(subdivisions=4, radius=0.2),
        trimesh.creation.box(extents=(0.4, 0.3, 0.25)).subdivide().subdivide().subdivide(),
        trimesh.creation.cone(radius=0.2, height=0.6, sections=48).subdivide().subdivide(),
        trimesh.creation.annulus(r_min=0.12, r_max=0.22, height=0.3, sections=40).subdivide(),
        trimesh.creation.box(extents=(0.35, 0.25, 0.05)).subdivide().subdivide().subdivide(),
    ]
    meshes = []
    for index in range(15):
        mesh = kinds[index % 5].copy()
        wave = np.sin((24 + 12 * (index // 5)) * mesh.vertices[:, [1, 2, 0]] + rng.uniform(0, 6, 3))
        mesh.vertices *= (1 + 0.02 * (1 + index // 5) * wave) * rng.uniform(0.8, 1.3, 3)
        meshes.append(mesh)
    return meshes


class SceneMaker:
    """Authors the scene as the reference script does."""

    def __init__(
        self, bodies: int, *, all_gravity: bool, area: tuple[float, float, float] = AREA, seed: int = 0
    ) -> None:
        self.stage = Usd.Stage.CreateInMemory()
        self.rng = random.Random(seed)
        self.all_gravity = all_gravity
        self.area = area
        self.root = os.environ.get("USDSDG_ASSETS_ROOT")
        UsdGeom.SetStageUpAxis(self.stage, "Z")
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        scene = UsdPhysics.Scene.Define(self.stage, "/PhysicsScene").GetPrim()
        scene.CreateAttribute("physxScene:timeStepsPerSecond", Sdf.ValueTypeNames.UInt).Set(60)
        self.add_walls()
        if not self.root:
            self.add_generated_assets()
        labeled = min(12, bodies)
        meshes = (bodies - labeled) * 175 // 325
        for index in range(labeled):
            self.add_asset(f"/World/Labeled/object_{index}", index % 2, LABELED, (1.0, 1.0), gravity=index > 4)
        for index in range(bodies - labeled - meshes):
            self.add_gprim(index)
        for index in range(meshes):
            paths = tuple(f"Isaac/Environments/{name}.usd" for name in DISTRACTORS)
            chosen = self.rng.randrange(len(paths))
            self.add_asset(f"/World/Distractors/mesh_{index}", chosen, paths, (0.35, 1.35), gravity=self.coin())

    def coin(self) -> bool:
        return self.rng.random() < 0.5 or self.all_gravity

    def add_walls(self) -> None:
        for axis, sign in ((a, s) for a in range(3) for s in (-1, 1)):
            size, at = list(self.area), [0.0, 0.0, 0.0]
            size[axis], at[axis] = 0.5, sign * (self.area[axis] + 0.5) / 2
            prim = self.stage.DefinePrim(f"/World/Walls/wall_{axis}{'np'[sign > 0]}", "Cube")
            UsdGeom.Xformable(prim).AddTranslateOp().Set(Gf.Vec3d(*at))
            UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(*(s / 2 for s in size)))
            self.add_collider(prim)

    def add_generated_assets(self) -> None:
        for index, made in enumerate(generated_meshes()):
            mesh = UsdGeom.Mesh.Define(self.stage, f"/Assets/mesh_{index}/mesh")
            self.stage.GetPrimAtPath(f"/Assets/mesh_{index}").SetSpecifier(Sdf.SpecifierClass)
            mesh.CreatePointsAttr(made.vertices.astype(np.float32))
            mesh.CreateFaceVertexCountsAttr(np.full(len(made.faces), 3, np.int32))
            mesh.CreateFaceVertexIndicesAttr(made.faces.astype(np.int32).ravel())

    def add_asset(self, path: str, index: int, assets: tuple[str, ...], scale: tuple[float, float], *, gravity: bool):
        prim = self.stage.DefinePrim(path, "Xform")
        if self.root:
            prim.GetReferences().AddReference(os.path.join(self.root, assets[index]))
        else:
            prim.GetReferences().AddInternalReference(f"/Assets/mesh_{index}")
        self.finish(prim, scale, gravity)

    def add_gprim(self, index: int) -> None:
        kind = self.rng.choice(["Capsule", "Cone", "Cylinder", "Sphere", "Cube"])
        prim = self.stage.DefinePrim(f"/World/Distractors/shape_{index}", kind)
        self.finish(prim, (0.015, 0.15), self.coin())

    def finish(self, prim: Usd.Prim, scale: tuple[float, float], gravity: bool) -> None:
        at = [self.rng.uniform(-size / 2, size / 2) for size in self.area]
        angles = [self.rng.uniform(0, 360) for _ in range(3)]
        for name, add, value in (
            ("xformOp:translate", "AddTranslateOp", Gf.Vec3d(*at)),
            ("xformOp:rotateXYZ", "AddRotateXYZOp", Gf.Vec3f(*angles)),
            ("xformOp:scale", "AddScaleOp", Gf.Vec3f(self.rng.uniform(*scale))),
        ):
            if not prim.HasAttribute(name):
                getattr(UsdGeom.Xformable(prim), add)()
            prim.GetAttribute(name).Set(value)
        for each in Usd.PrimRange(prim):
            if each.IsA(UsdGeom.Gprim):
                self.add_collider(each)
        UsdPhysics.RigidBodyAPI.Apply(prim)
        prim.CreateAttribute("physxRigidBody:disableGravity", Sdf.ValueTypeNames.Bool).Set(not gravity)

    def add_collider(self, prim: Usd.Prim) -> None:
        UsdPhysics.CollisionAPI.Apply(prim)
        prim.CreateAttribute("physxCollision:contactOffset", Sdf.ValueTypeNames.Float).Set(0.001)
        prim.CreateAttribute("physxCollision:restOffset", Sdf.ValueTypeNames.Float).Set(0.0)
        if prim.IsA(UsdGeom.Mesh):
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr("convexHull")


def report(
    engine: NewtonEngine, stage: Usd.Stage, frame: int, milliseconds: list[float], query_milliseconds: list[float]
) -> None:
    """Print a line on one frame; a body is outside when its center is: an asset's origin is at its bottom."""
    bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    prims = [stage.GetPrimAtPath(path) for path in engine.rigid_bodies]
    at = np.array([bounds.ComputeWorldBound(prim).ComputeCentroid() for prim in prims])
    speed = np.array([np.linalg.norm(prim.GetAttribute("physics:velocity").Get() or (0, 0, 0)) for prim in prims])
    with_gravity = np.array([not prim.GetAttribute("physxRigidBody:disableGravity").Get() for prim in prims])
    out = (np.abs(at) > np.array(AREA) / 2).any(axis=1)
    print(
        f"{frame / 60:5.1f} s: {np.median(milliseconds[-60:]):6.2f} ms per frame, "
        f"overlap {np.median(query_milliseconds[-60:]):.2f} ms; "
        f"{out.sum()} of {len(prims)} outside; under gravity: median {np.median(speed[with_gravity]) * 1e3:.2f} mm/s, "
        f"{(speed[with_gravity] == 0).sum()} of {with_gravity.sum()} at rest",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--device", default=None)
    parser.add_argument("--bodies", type=int, default=337)
    parser.add_argument("--all-gravity", action="store_true")
    options = parser.parse_args()
    stage = SceneMaker(options.bodies, all_gravity=options.all_gravity).stage
    engine = NewtonEngine(stage, device=options.device, progress=lambda *step: print(*step, flush=True))
    start = time.perf_counter()
    engine.play()
    print(f"play: {time.perf_counter() - start:.2f} s, {len(engine.rigid_bodies)} bodies")
    start = time.perf_counter()
    engine.advance(1 / 60)
    print(f"first step: {time.perf_counter() - start:.2f} s")
    milliseconds, query_milliseconds = [], []
    for frame in range(1, round(options.seconds * 60) + 1):
        start = time.perf_counter()
        engine.advance(1 / 60)
        milliseconds.append(1e3 * (time.perf_counter() - start))
        start = time.perf_counter()
        engine.overlap_box((2.475, 2.475, 0.0495), (0, 0, -1.45))
        query_milliseconds.append(1e3 * (time.perf_counter() - start))
        if frame in (60, 300) or frame % 600 == 0:
            report(engine, stage, frame, milliseconds, query_milliseconds)
    print("digest", hashlib.sha256(stage.GetRootLayer().ExportToString().encode()).hexdigest()[:16])


if __name__ == "__main__":
    main()
