"""Time from a stage edit until rays can be traced again, compared with extracting the whole stage.

    python -m benchmarks.updates [--rounds 15]

The edit itself is not timed; each row times `WarpRenderer.sync` and the reading of the camera.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from benchmarks import report
from benchmarks.render_stage import random_poses, write_poses
from benchmarks.timing import Work, alone
from benchmarks.update_stage import CAMERA, World, make_world, positions
from tests.stage.geometry.characters import add_character
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.semantics.labels import add_labels, remove_labels
from usdsdg_render.images.textures import TexturePool, TextureUse
from usdsdg_render.renderer import WarpRenderer


class Change(NamedTuple):
    """A kind of edit: its function of the round, the target, and an untimed preparation."""

    name: str
    edit: Work
    target: str
    before: Work | None = None


class Edits:
    """Edits of a `World`; they differ between rounds, and none makes the scene grow."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.stage = world.stage
        self.rng = np.random.default_rng(5)
        self.mesh = UsdGeom.Mesh(world.stage.GetPrimAtPath("/World/object_0/Mesh"))
        self.rest = np.array(self.mesh.GetPointsAttr().Get())

    def poses(self, k: int) -> None:
        write_poses(self.world.ops, random_poses(len(self.world.ops), k))

    def paint(self, which: int) -> None:
        self.world.surface(which).GetInput("diffuseColor").Set(self._color())

    def bind(self, k: int) -> None:
        material = UsdShade.Material.Get(self.stage, f"/World/object_{200 + k % 2}/Look")
        UsdShade.MaterialBindingAPI(self.stage.GetPrimAtPath("/World/object_100")).Bind(material)

    def known_texture(self, k: int) -> None:
        self.world.file(1).Set(self.world.textures[k % 2])

    def new_texture(self, k: int) -> None:
        self.world.file(0).Set(self.world.new_texture(k))

    def add(self, _: int) -> None:
        self.stage.DefinePrim("/World/New", "Xform").GetReferences().AddReference(self.world.asset)

    def remove(self, _: int) -> None:
        self.stage.RemovePrim("/World/New")

    def show(self, k: int) -> None:
        visibility = UsdGeom.Imageable(self.stage.GetPrimAtPath("/World/object_7")).CreateVisibilityAttr()
        visibility.Set(UsdGeom.Tokens.invisible if k % 2 else UsdGeom.Tokens.inherited)

    def light(self, k: int) -> None:
        self.world.attribute("/World/Lamp_0.inputs:intensity").Set(20000.0 + k)
        self.world.attribute("/World/Lamp_0.inputs:color").Set(self._color())

    def known_sky(self, k: int) -> None:
        self.world.attribute("/World/Sky.inputs:texture:file").Set(self.world.skies[k % 2])

    def new_sky(self, k: int) -> None:
        self.world.attribute("/World/Sky.inputs:texture:file").Set(self.world.new_sky(k))

    def dim_sky(self, k: int) -> None:
        self.world.attribute("/World/Sky.inputs:intensity").Set(400.0 + k)

    def label(self, k: int) -> None:
        prim = self.stage.GetPrimAtPath("/World/object_9")
        remove_labels(prim)
        add_labels(prim, {"class": f"other_{k}"})

    def camera(self, k: int) -> None:
        self.world.attribute(f"{CAMERA}.xformOp:translate").Set(Gf.Vec3d(0.1 * k, 0, 6))
        UsdGeom.Camera(self.stage.GetPrimAtPath(CAMERA)).CreateFocalLengthAttr().Set(20.0 + k)

    def bend(self, k: int) -> None:
        self.mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy((self.rest * (1 + 0.01 * k)).astype(np.float32)))

    def scatter(self, _: int) -> None:
        self.world.attribute("/World/Points.positions").Set(positions(self.rng))

    def vary(self, k: int) -> None:
        self.stage.GetPrimAtPath("/World/Varied").GetVariantSet("shape").SetVariantSelection("ba"[k % 2])

    def frame(self, k: int) -> None:
        """Make the edits of a randomizing script in one frame; its textures are from a list that repeats."""
        some = self.rng.permutation(len(self.world.ops))[:100]
        write_poses([self.world.ops[each] for each in some], random_poses(100, k))
        with Sdf.ChangeBlock():
            for each in range(20):
                self.paint(50 + each)
            for each in range(5):
                self.world.file(each).Set(self.world.textures[(k + 7 * each) % len(self.world.textures)])
            for each in range(2):
                self.world.attribute(f"/World/Lamp_{each}.inputs:intensity").Set(10000.0 + k)

    def _color(self) -> Gf.Vec3f:
        return Gf.Vec3f(*self.rng.random(3).tolist())


def changes(world: World) -> list[Change]:
    """Return all kinds of edits but that of time."""
    edits = Edits(world)
    return [
        Change("nothing", lambda _: None, ""),
        Change("all 337 poses", edits.poses, "3 ms"),
        Change("the color of a material", lambda _: edits.paint(60), "5 ms"),
        Change("the material of a prim", edits.bind, "5 ms"),
        Change("a texture, seen before", edits.known_texture, "5 ms"),
        Change("a new texture", edits.new_texture, "reading it + 5 ms"),
        Change("a mesh asset added", edits.add, "reading it + 15 ms", edits.remove),
        Change("a mesh asset removed", edits.remove, "15 ms", edits.add),
        Change("visibility of a prim", edits.show, "5 ms"),
        Change("a light", edits.light, "5 ms"),
        Change("the sky's intensity", edits.dim_sky, "5 ms"),
        Change("a sky, seen before", edits.known_sky, "5 ms"),
        Change("a new sky", edits.new_sky, "reading it + 5 ms"),
        Change("a label", edits.label, "5 ms"),
        Change("the camera", edits.camera, "5 ms"),
        Change("points of a mesh", edits.bend, "the mesh + 15 ms"),
        Change("positions of 100 points", edits.scatter, "5 ms"),
        Change("a variant", edits.vary, "the mesh + 15 ms"),
        Change("a randomized frame", edits.frame, ""),
    ]


def print_row(name: str, work: Work, rounds: int, target: str = "", before: Work | None = None) -> None:
    timings = alone(work, rounds=rounds, before=before)
    report.row(name, f"{1e3 * timings.wall:.2f} ms", f"{1e3 * timings.cpu:.2f} ms CPU", target=target)


def the_whole(world: World, rounds: int) -> None:
    """Time what edits are compared with: the whole stage, and one texture."""
    print_row("the whole stage", lambda _: WarpRenderer(world.stage, device="cpu").sync(), max(rounds // 3, 3))
    print_row("a texture alone", lambda _: TexturePool().load([TextureUse(world.textures[0])]), rounds)


def of_changes(world: World, rounds: int) -> None:
    renderer = WarpRenderer(world.stage, device="cpu")

    def ready(_: int) -> None:
        renderer.sync()
        read_camera(world.stage, CAMERA, (640, 480))

    for change in changes(world):

        def edit(k: int, change: Change = change) -> None:
            if change.before is not None:
                change.before(k)
            renderer.sync()
            change.edit(k)

        print_row(change.name, ready, rounds, change.target, edit)


def of_time(stage: Usd.Stage, rounds: int) -> None:
    """Time another time code, at which one skinned mesh deforms among the others."""
    add_character(stage, "/World/Man")
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync(Usd.TimeCode(0))
    codes = np.linspace(1, 23, rounds + 1)
    print_row("time, one character", lambda k: renderer.sync(Usd.TimeCode(codes[k])), rounds, "the mesh + 15 ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    report.begin()
    with tempfile.TemporaryDirectory() as folder:
        world = make_world(Path(folder))
        the_whole(world, rounds)
        of_changes(world, rounds)
        of_time(world.stage, rounds)


if __name__ == "__main__":
    main()
