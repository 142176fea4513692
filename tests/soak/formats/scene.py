"""A cluttered scene in which things appear and vanish, written by any number of writers at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pxr import Gf, UsdGeom

import usdsdg as rep
from usdsdg.graph.sampling import set_global_seed
from usdsdg.session import session
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.poses.look_at import look_at_matrix
from usdsdg.stage.semantics.labels import add_labels

CLASSES = ("ball", "can", "crate", "figure", "ghost", "ring")  # "ghost" is on the stage, and never visible
KEYPOINTS: dict[str, dict[str, tuple[float, float, float]]] = {
    "crate": {
        f"corner_{x}{y}{z}": (0.6 * x - 0.3, 0.45 * y - 0.225, 0.5 * z - 0.25)
        for x in (0, 1) for y in (0, 1) for z in (0, 1)
    },
    "figure": {"head": (0, 0, 0.75), "nose": (0, -0.23, 0.75), "left": (0.3, 0, 0), "right": (-0.3, 0, 0)},
}  # fmt: skip
SKELETON = {"figure": [("head", "nose"), ("head", "left"), ("head", "right")]}
SIZE = (160, 120)
_LEVEL = 0.35  # height of a level camera


class Wanted(NamedTuple):
    """A writer, the options of its `initialize` but for output_dir, and how many of the cameras it is attached to."""

    writer: str
    options: Mapping[str, Any] = {}
    cameras: int = 1


def make(
    folder: Path,
    wanted: Mapping[str, Wanted],
    *,
    frames: int = 200,
    seed: int = 1,
    size: tuple[int, int] = SIZE,
    things: int = 24,
    upright: bool = False,
) -> Path:
    """Write one run of the scene with every wanted writer, each into the folder of its name; return `folder`.

    size: width and height of the pictures [pixels]. things: how many there are, not all of them visible at once.
    upright: things only turn about the vertical, before level cameras, as in KITTI's labels.
    """
    session.restart()
    set_global_seed(seed)
    scene = Scene(seed, things=things, upright=upright)
    products = [rep.create.render_product(path, size) for path in scene.cameras]
    writers = []
    for name, (kind, options, cameras) in wanted.items():
        writer = rep.writers.get(kind)
        writer.initialize(output_dir=str(folder / name), **options)
        writer.attach(products[:cameras])
        writers.append(writer)
    for frame in range(frames):
        scene.move(frame)
        rep.orchestrator.step(delta_time=0.0)
    rep.orchestrator.wait_until_complete()
    for writer in writers:
        writer.on_final_frame()
        writer.detach()
    rep.orchestrator.wait_until_complete()
    session.restart()
    return folder


class Scene:
    """Labeled things and unlabeled boards over a floor; every frame places them anew, and hides some.

    Frames with many things, few and none take turns. Some things reach out of the picture, are behind others to the
    last pixel, in several pieces, or have holes. Cameras: /World/Left and /World/Right. The stage has +Z up, in meters.
    """

    cameras = ("/World/Left", "/World/Right")

    def __init__(self, seed: int, *, things: int = 24, upright: bool = False) -> None:
        self._random, self._upright = np.random.default_rng(seed), upright
        stage = new_stage()
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        self._block("/World/Floor", (9, 9, 0.1)).AddTranslateOp().Set(Gf.Vec3d(0, 1, -1.5))
        kinds = [name for name in CLASSES if name != "ghost"]
        self._things = [self._thing(index, kinds[index % len(kinds)]) for index in range(things)]
        self._boards = [self._placed(self._block(f"/World/Board_{index}", (0.05, 1.2, 0.12))) for index in range(3)]
        ghost = self._block("/World/Ghost", (0.5, 0.5, 0.5))
        add_labels(ghost.GetPrim(), {"class": ["ghost"]})
        ghost.GetVisibilityAttr().Set("invisible")
        for path, aside in zip(self.cameras, (-0.8, 1.2)):
            self._camera(path, aside)
        rep.create.light(light_type="dome")

    def move(self, frame: int) -> None:
        """Place everything for a frame: by turns all things, half of them, one, and in one of ten none."""
        shown = (1.0, 0.7, 0.4, 0.7, 1.0, 0.15, 0.7, 1.0, 0.4, 0.0)[frame % 10]
        for index, thing in enumerate(self._things):
            self._place(thing)
            visible = self._random.random() < shown or (frame % 10 == 5 and index == 0)
            thing.GetVisibilityAttr().Set("inherited" if visible else "invisible")
        for board in self._boards:
            self._place(board)

    def _place(self, prim: UsdGeom.Xformable) -> None:
        translate, orient = prim.GetOrderedXformOps()[:2]
        translate.Set(Gf.Vec3d(*self._random.uniform((-1.6, -1.2, -0.9), (1.6, 2.5, 1.5)).tolist()))
        angle = self._random.uniform(0, 2 * np.pi)
        turn = np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)]) if self._upright else self._random.normal(size=4)
        turn = (turn / np.linalg.norm(turn)).tolist()
        orient.Set(Gf.Quatd(turn[0], *turn[1:]))

    def _camera(self, path: str, aside: float) -> None:
        camera = UsdGeom.Camera.Define(current_stage(), path)
        eye, target = ((aside, -5, _LEVEL), (aside, 0, _LEVEL)) if self._upright else ((aside, -5, 1.5), (0, 0, 0.2))
        camera.AddTransformOp().Set(look_at_matrix(eye, target, up=(0, 0, 1)))
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.05, 100.0))

    def _thing(self, index: int, kind: str) -> UsdGeom.Xformable:
        path = f"/World/Thing_{index}"
        root = UsdGeom.Xform.Define(current_stage(), path)
        add_labels(root.GetPrim(), {"class": [kind]})
        scale = float(self._random.uniform(0.5, 0.9))
        {"ball": self._ball, "can": self._can, "crate": self._crate, "figure": self._figure, "ring": self._ring}[kind](
            path
        )
        if kind in KEYPOINTS:
            set_keypoints(root.GetPrim(), KEYPOINTS[kind])
        placed = self._placed(root)
        root.AddScaleOp().Set(Gf.Vec3f(scale))
        return placed

    def _placed(self, prim: UsdGeom.Xformable) -> UsdGeom.Xformable:
        """Give a prim a translation and a turn before the operations that it has."""
        others = prim.GetOrderedXformOps()
        order = [prim.AddTranslateOp(opSuffix="place"), prim.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)]
        prim.SetXformOpOrder([*order, *others])
        return prim

    def _colored(self, gprim: UsdGeom.Gprim) -> UsdGeom.Gprim:
        gprim.CreateDisplayColorAttr([Gf.Vec3f(*self._random.uniform(0, 1, 3).tolist())])
        return gprim

    def _block(self, path: str, size: Sequence[float]) -> UsdGeom.Gprim:
        """Make a box with its origin in the center."""
        points = [
            (x * size[0] / 2, y * size[1] / 2, z * size[2] / 2) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)
        ]
        faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
        return self._mesh(path, points, faces)

    def _mesh(self, path: str, points: Sequence[Sequence[float]], faces: Sequence[Sequence[int]]) -> UsdGeom.Gprim:
        mesh = UsdGeom.Mesh.Define(current_stage(), path)
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, each)) for each in points])
        mesh.CreateFaceVertexCountsAttr([len(face) for face in faces])
        mesh.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
        mesh.CreateSubdivisionSchemeAttr("none")
        return self._colored(mesh)

    def _ball(self, path: str) -> None:
        self._colored(UsdGeom.Sphere.Define(current_stage(), f"{path}/Body")).CreateRadiusAttr(0.35)

    def _can(self, path: str) -> None:
        body = UsdGeom.Cylinder.Define(current_stage(), f"{path}/Body")
        body.CreateRadiusAttr(0.22)
        body.CreateHeightAttr(0.7)
        self._colored(body)

    def _crate(self, path: str) -> None:
        self._block(f"{path}/Body", (1, 1, 1)).AddScaleOp().Set(Gf.Vec3f(0.6, 0.45, 0.5))

    def _figure(self, path: str) -> None:
        self._block(f"{path}/Body", (0.35, 0.25, 0.9))
        head = UsdGeom.Sphere.Define(current_stage(), f"{path}/Head")
        head.CreateRadiusAttr(0.22)
        head.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.75))
        self._colored(head)

    def _ring(self, path: str, *, around: int = 16, across: int = 8) -> None:
        """Make a torus, so that masks have holes."""
        u, v = np.meshgrid(
            np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij"
        )
        radius = 0.4 + 0.12 * np.cos(v)
        points = np.stack([radius * np.cos(u), radius * np.sin(u), 0.12 * np.sin(v)], axis=-1).reshape(-1, 3)
        index = np.arange(around * across).reshape(around, across)
        beside, above = np.roll(index, -1, axis=0), np.roll(index, -1, axis=1)
        faces = np.stack([index, beside, np.roll(beside, -1, axis=1), above], axis=-1).reshape(-1, 4)
        self._mesh(f"{path}/Body", points.tolist(), faces.tolist())
