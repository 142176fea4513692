"""Large scenes: a terrain of a million triangles, bodies far from the origin, and many copies of a world in one stage.

    python -m benchmarks.physics_large [--device cpu] [--only terrain far copies] [--quick]

Prints CPU times of the process on the CPU, wall times on CUDA, and the greatest memory of the process.
"""

from __future__ import annotations

import argparse
import resource

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics, Vt

from benchmarks.physics_speed import DT, Clock, report, world_of
from usdsdg_physics import NewtonEngine

TERRAIN = 100.0  # m
DISTANCES = (0.0, 1e3, 1e4, 1e5)  # m
SHAPES = ("Cube", "Sphere", "Cylinder", "Cone")


def new_stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.Scene.Define(stage, "/PhysicsScene")
    return stage


def add(stage: Usd.Stage, path: str, kind: str, at, half, *, body: bool = True) -> Usd.Prim:
    prim = stage.DefinePrim(path, kind)
    xformable = UsdGeom.Xformable(prim)
    xformable.AddTranslateOp().Set(Gf.Vec3d(*map(float, at)))
    xformable.AddScaleOp().Set(Gf.Vec3f(*half))
    UsdPhysics.CollisionAPI.Apply(prim)
    if body:
        UsdPhysics.RigidBodyAPI.Apply(prim)
    return prim


def height(x, y):
    """Height of the terrain [m], of hills with bumps."""
    return 1.5 * np.sin(x / 7) * np.cos(y / 9) + 0.2 * np.sin(x * 1.3) * np.sin(y * 1.1)


def terrain(stage: Usd.Stage, side: int) -> int:
    """Add a terrain with so many points along each side; return its number of triangles."""
    line = np.linspace(-TERRAIN / 2, TERRAIN / 2, side)
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3).astype(np.float32)
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)
    mesh = UsdGeom.Mesh.Define(stage, "/World/terrain")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.ravel()))
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr("none")
    return len(triangles)


def position(prim: Usd.Prim) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation())


def start(stage: Usd.Stage, what: str, device: str, clock: Clock) -> NewtonEngine:
    """Play a stage; print what loading takes."""
    engine = NewtonEngine(stage, device=device)
    engine.play()
    taken = clock.milliseconds(lambda: (engine.advance(DT), world_of(engine).poses()))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    report(f"load {what} and take a step", taken, f"{memory:.2f} GB at most")
    return engine


def steps(engine: NewtonEngine, count: int, what: str, clock: Clock) -> None:
    """Take steps, and print the mean of their times."""

    def run() -> None:
        for _ in range(count):
            engine.advance(DT)
        world_of(engine).poses()

    report(what, clock.milliseconds(run) / count)


def measure_terrain(side: int, device: str, clock: Clock) -> None:
    stage, draw = new_stage(), np.random.default_rng(0)
    count = terrain(stage, side)
    bodies = []
    for number, (x, y) in enumerate(draw.uniform(-0.4 * TERRAIN, 0.4 * TERRAIN, (100, 2))):
        kind = SHAPES[number % 2]
        bodies.append(add(stage, f"/World/body_{number}", kind, (x, y, height(x, y) + 0.6), (0.2, 0.2, 0.2)))
    engine = start(stage, f"{count} triangles, 100 bodies", device, clock)
    steps(engine, 300, "step on the terrain, in five seconds", clock)
    x, y, z = np.array([position(body) for body in bodies]).T
    above = z - height(x, y)
    print(f"{(above < -0.5).sum()} of 100 bodies fell through; the lowest is {above.min():.3f} m above (0.2 m thick)")


def measure_distances(device: str) -> None:
    for distance in DISTANCES:
        stage = new_stage()
        add(stage, "/World/ground", "Cube", (distance, 0, -0.5), (5, 5, 0.5), body=False)
        bodies = [add(stage, f"/World/body_{n}", "Cube", (distance + n, 0, 0.3), (0.1, 0.1, 0.1)) for n in range(3)]
        engine = NewtonEngine(stage, device=device)
        engine.play()
        for _ in range(180):
            engine.advance(DT)
        errors = np.array([position(body) - (distance + n, 0, 0.1) for n, body in enumerate(bodies)])
        print(f"{distance / 1e3:5g} km from the origin: bodies at rest are {1e6 * np.abs(errors).max():.1f} um off")


def measure_copies(copies: int, device: str, clock: Clock) -> None:
    stage = new_stage()
    for copy in range(copies):
        corner = np.array([6.0 * (copy % 10), 6.0 * (copy // 10), 0.0])
        draw = np.random.default_rng(7)
        add(stage, f"/World/copy_{copy}/ground", "Cube", corner - (0, 0, 0.5), (2.5, 2.5, 0.5), body=False)
        for number in range(20):
            at = corner + np.array([*draw.uniform(-1, 1, 2), 0.3 + 0.3 * number])
            add(stage, f"/World/copy_{copy}/body_{number}", SHAPES[number % 4], at, (0.1, 0.1, 0.1))
    engine = start(stage, f"{copies} copies of a world of 20 bodies", device, clock)
    steps(engine, 60, "step of the copies, in the first second", clock)
    steps(engine, 60, "step of the copies, in the next one", clock)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--only", nargs="*", default=["terrain", "far", "copies"])
    parser.add_argument("--quick", action="store_true", help="small scenes, to see that it works")
    options = parser.parse_args()
    clock = Clock(options.device)
    if "terrain" in options.only:
        measure_terrain(72 if options.quick else 708, options.device, clock)
    if "far" in options.only:
        measure_distances(options.device)
    if "copies" in options.only:
        measure_copies(5 if options.quick else 100, options.device, clock)


if __name__ == "__main__":
    main()
