"""CPU time of annotators: a frame of 337 labeled objects with all of BasicWriter's annotators and our own.

    python -m benchmarks.annotators [--rounds 9] [--all]

Poses change before every frame. Prints the CPU time, of all threads together, of the pass that renders AOVs and masks,
and beyond it of reading the labeled prims, of each annotator in turn (what two of them share counts for the first), and
of the rays that some of them send themselves: those of keypoints and correspondences, and around the picture. With
--all, every registered annotator that needs no parameter, under each of its names.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from benchmarks import report
from benchmarks.render_scene import build, views
from benchmarks.render_stage import author, write_poses
from usdsdg.annotators import get_registered_annotators, requirements
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.labeled_prims import LabeledPrimReader
from usdsdg.capture.frame_scene import EarlierPoints, FrameScene
from usdsdg.capture.subsets import gprim_table
from usdsdg.session import engines
from usdsdg.session.stage_context import set_stage
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.keypoints import set_keypoints
from usdsdg.stage.semantics.labels import add_labels
from usdsdg_render.settings import LIGHT_AOVS

SIZE = (640, 480)
CAMERA, OTHER = "/World/Camera", "/World/Other"
BASIC_WRITER = (
    "rgb", "normals", "distance_to_camera", "distance_to_image_plane", "motion_vectors", "semantic_segmentation",
    "instance_id_segmentation", "instance_segmentation", "bounding_box_2d_tight", "bounding_box_2d_loose",
    "bounding_box_3d", "occlusion", "camera_params", "pointcloud", "skeleton_data",
)  # fmt: skip
OWN: dict[str, dict[str, Any]] = {
    "amodal_instance_segmentation": {"encoding": "rle"}, "visibility": {}, "occlusion_graph": {}, "truncation": {},
    "bounding_box_2d_amodal": {}, "oriented_bounding_box_2d": {}, "oriented_bounding_box_2d_amodal": {},
    "object_coordinates": {}, "keypoints": {}, "dense_correspondence": {"camera": OTHER},
}  # fmt: skip
COLORIZED = ("semantic_segmentation", "instance_id_segmentation", "instance_segmentation")
LIMIT_MS = 60
# Rays that annotators send themselves, for the truncation, keypoints and dense correspondence.
RAYS = ("rays around the picture", "rays to keypoints", "rays to points of pixels")


class Watch:
    """CPU seconds of named parts, a list for each."""

    def __init__(self) -> None:
        self.seconds: dict[str, list[float]] = defaultdict(list)

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        started = time.process_time()
        yield
        self.seconds[part].append(time.process_time() - started)

    def ms(self, part: str) -> float:
        return 1e3 * statistics.median(self.seconds[part]) if part in self.seconds else 0.0


class TimedScene(FrameScene):
    """The scene of a frame, whose own rays are timed."""

    def __init__(self, watch: Watch, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.rays, self._watch = 0.0, watch

    def coverage_around(self, *arguments: Any) -> np.ndarray:
        return self._timed(RAYS[0], super().coverage_around, *arguments)

    def first_hits(self, *arguments: Any) -> tuple[np.ndarray, np.ndarray]:
        return self._timed(RAYS[1], super().first_hits, *arguments)

    def follow(self, *arguments: Any) -> tuple[np.ndarray, np.ndarray]:
        return self._timed(RAYS[2], super().follow, *arguments)

    def _timed(self, part: str, work: Any, *arguments: Any) -> Any:
        with self._watch(part):
            result = work(*arguments)
        self.rays += self._watch.seconds[part][-1]
        return result


def labeled_stage(folder: Path) -> tuple[Usd.Stage, list[Usd.Attribute], np.ndarray]:
    """Author the benchmark scene with labels, keypoints and two cameras; return it with transforms and their values."""
    scene = build()
    stage, ops = author(scene, folder)
    for k, op in enumerate(ops):
        prim = op.GetPrim()
        add_labels(prim, {"class": f"kind_{scene.instances.prototype[k]}"})
        if k % 10 == 0:
            set_keypoints(prim, {f"corner_{n}": [0.5 * (-1) ** (n >> axis) for axis in range(3)] for n in range(8)})
    view = views(scene, SIZE)[1]
    for path, shift in ((CAMERA, 0.0), (OTHER, 0.2)):
        camera = UsdGeom.Camera.Define(stage, path)
        camera.AddTransformOp().Set(Gf.Matrix4d(view.local_to_world.tolist()).SetTranslateOnly(
            Gf.Vec3d(*view.local_to_world[3, :3]) + Gf.Vec3d(shift)
        ))  # fmt: skip
        camera.CreateFocalLengthAttr(view.focal_length)
        camera.CreateHorizontalApertureAttr(view.horizontal_aperture)
        camera.CreateClippingRangeAttr(Gf.Vec2f(*view.clipping_range))
    return set_stage(stage), ops, scene.instances.local_to_world


def measure(stage: Usd.Stage, ops: list, poses: np.ndarray, names: list[str], rounds: int) -> Watch:
    """Time `rounds` frames after one that warms up."""
    watch = Watch()
    product = rep.create.render_product(CAMERA, SIZE)
    found = {}
    for name in names:
        given = OWN.get(name, {}) | ({"colorize": True} if name in COLORIZED else {})
        found[name] = rep.annotators.get(name, init_params=given).attach(product)
    needs = requirements(found.values())
    renderer, reader = engines.renderer(), LabeledPrimReader(stage)
    rng = np.random.default_rng(0)
    images = {
        "LdrColor": np.full((SIZE[1], SIZE[0], 4), 128, np.uint8), "HdrColor": np.ones((SIZE[1], SIZE[0], 4), "f2"),
    }  # fmt: skip
    for number in range(rounds + 1):
        if number == 1:
            watch.seconds.clear()
        moved = poses.copy()
        moved[:, 3, :3] += rng.normal(size=(len(poses), 3)) * 0.002
        write_poses(ops, moved)
        renderer.sync()
        table = gprim_table(renderer.gprims, renderer.time)
        with watch("labeled prims"):
            labeled = reader.read(table.gprims, needs.filters, time=renderer.time)
        view = read_camera(stage, CAMERA, SIZE)
        lit = [name for name in needs.aovs if name not in LIGHT_AOVS]
        with watch("AOVs and masks"):
            (aovs,), (masks,) = renderer.labels_and_masks([view], lit, labeled.groups)
        aovs |= images | {name: np.ones((SIZE[1], SIZE[0], 3), np.float32) for name in needs.aovs - set(lit)}
        _frame(watch, found, Frame(
            index=number, view=view, render_product=product.path, aovs=aovs, gprims=table.gprims, labeled_prims=labeled,
            amodal_masks=masks,
            scene=TimedScene(watch, product.path, view, table, aovs, EarlierPoints(), renderer),
        ))  # fmt: skip
    return watch


def _frame(watch: Watch, annotators: dict[str, Any], frame: Frame) -> None:
    scene = frame.scene
    assert isinstance(scene, TimedScene)
    assert isinstance(frame.view, CameraView)
    for name, annotator in annotators.items():
        scene.rays = 0.0
        started = time.process_time()
        annotator.compute(frame)
        watch.seconds[name].append(time.process_time() - started - scene.rays)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--all", action="store_true", help="every registered annotator")
    options = parser.parse_args()
    names = [*BASIC_WRITER, *OWN]
    if options.all:
        left_out = ("Attribute", "cross_correspondence", "CrossCorrespondence")
        names += [name for name in get_registered_annotators() if name not in (*names, *left_out)]
    report.begin()
    with tempfile.TemporaryDirectory() as folder:
        watch = measure(*labeled_stage(Path(folder)), names, options.rounds)
    for part in ("AOVs and masks", "labeled prims", *names, *RAYS):
        report.row(part, f"{watch.ms(part):.2f} ms CPU")
    total = sum(watch.ms(name) for name in (*names, "labeled prims"))
    report.row("annotators, labeled prims", f"{total:.1f} ms CPU", target=f"at most {LIMIT_MS} ms")


if __name__ == "__main__":
    main()
