"""Simulate a stage for some time without a timeline, and compile kernels ahead."""

from collections.abc import Callable, Sequence

from pxr import Usd, UsdGeom, UsdPhysics

from usdsdg.errors import warn_once
from usdsdg.stage.physics.rest import still_moving
from usdsdg_physics.engine import NewtonEngine
from usdsdg_physics.world.compile_kernels import Progress, load_all_kernels

MAX_SETTLE_TIME = 10.0  # s
_PLAIN_GPRIMS, _ROUNDED_GPRIMS = ("Cube", "Sphere", "Mesh"), ("Capsule", "Cylinder", "Cone")


def simulate(
    stage: Usd.Stage,
    seconds: float,
    *,
    frames_per_second: float = 60.0,
    device: str | None = None,
    progress: Progress | None = None,
    on_frame: Callable[[int], None] | None = None,
    settle: bool = False,
) -> int:
    """Simulate the rigid bodies of a stage for `seconds` and leave them where they end, in the current edit target.

    Args:
        frames_per_second: how often `on_frame(frame)` and `progress("simulating", frame, frames)` are called; the steps
            between are those of the stage's PhysicsScene.
        on_frame: called after each frame, the first time with 1; without it the stage has only the end.
        settle: before the first frame, move bodies that overlap apart and let all come to rest, for 10 s at most.

    Returns:
        The number of physics steps.
    """
    engine = NewtonEngine(stage, device=device, progress=progress)
    engine.play()
    if not engine.rigid_bodies:
        warn_once(
            "the stage has no rigid body, so nothing moves. Apply UsdPhysics.RigidBodyAPI to what shall fall, and "
            "CollisionAPI to the shapes at or under it."
        )
    if settle and (moving := engine.settle()):
        warn_once(still_moving(moving, MAX_SETTLE_TIME))
    frames = max(1, round(seconds * frames_per_second))
    steps = 0
    for frame in range(1, frames + 1):
        steps += engine.advance(seconds / frames, write=on_frame is not None or frame == frames)
        if on_frame:
            on_frame(frame)
        if progress:
            progress("simulating", frame, frames)
    engine.stop(restore=False)
    return steps


def precompile(*, device: str | None = None, progress: Progress | None = None) -> None:
    """Compile every kernel that any scene needs, by stepping two that differ in shapes; quick when they are cached."""
    # Newton has another narrow phase for scenes without rounded shapes.
    for kinds in (_PLAIN_GPRIMS, (*_PLAIN_GPRIMS, *_ROUNDED_GPRIMS)):
        _step_scene(kinds, device, progress)
    load_all_kernels(device, progress=progress)


def _step_scene(kinds: Sequence[str], device: str | None, progress: Progress | None) -> None:
    """Step a scene that has a body of each kind above a mesh of triangles."""
    stage = Usd.Stage.CreateInMemory()
    for height, kind in enumerate(("Cube", *kinds)):
        prim = stage.DefinePrim(f"/{kind}_{height}", kind)
        UsdGeom.Xformable(prim).AddTranslateOp().Set((0.0, 0.0, 1.5 * height))
        if kind == "Mesh":
            _author_tetrahedron(UsdGeom.Mesh(prim))
        UsdPhysics.CollisionAPI.Apply(prim)
        if height:
            UsdPhysics.RigidBodyAPI.Apply(prim)
    ground = UsdGeom.Mesh.Define(stage, "/Ground")
    ground.AddTranslateOp().Set((0.0, 0.0, -3.0))
    _author_tetrahedron(ground)
    UsdPhysics.CollisionAPI.Apply(ground.GetPrim())  # of triangles, as it is static
    engine = NewtonEngine(stage, device=device, progress=progress)
    engine.play()
    engine.advance(1.0 / 60.0)
    engine.overlap_sphere(1.0, (0.0, 0.0, 0.0))


def _author_tetrahedron(mesh: UsdGeom.Mesh) -> None:
    mesh.CreatePointsAttr([(-1, -1, -1), (1, -1, -1), (0, 1, -1), (0, 0, 1)])
    mesh.CreateFaceVertexCountsAttr([3, 3, 3, 3])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
