"""The renderer on CUDA: rays, paths, labels and updates of the benchmark scene, and whether both devices agree.

    python -m benchmarks.cuda [--device cuda:0] [--rounds 5]

Times are wall times of work including its synchronization, medians of the rounds after a warm-up round.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
import warp as wp

from benchmarks import render_scene
from benchmarks.render_labels import LABELS
from benchmarks.sensor_camera import SensorCameras
from benchmarks.timing import in_turns
from tests.render.bvh.trace_rays import trace_rays
from tests.render.path.test_wavefront import VIEW, everything
from tests.stage.cameras.lens_cases import CASES
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.renderer import WarpRenderer
from usdsdg_render.scene.structs import Hit
from usdsdg_render.settings import PathSettings

BLOCK = 128
CAMERAS = 16
SAMPLES = 128
MANY = 256
# Orders in which SensorCamera's threads process pixels, its default first.
ORDERS = ("PIXEL_PRIORITY", "VIEW_PRIORITY", "TILED")
SMALL, SMALL_CAMERAS = 128, 64


class Bench:
    """One renderer on the device, and its timers."""

    def __init__(self, device: str, rounds: int) -> None:
        self.device, self.rounds = device, rounds
        self.scene = render_scene.build()
        self.views = render_scene.views(self.scene)
        self.renderer = WarpRenderer.of_scene(self.scene, device=device)
        self.renderer.sync()

    def seconds(self, work) -> float:
        def waited(_: int) -> None:
            work()
            wp.synchronize_device(self.device)

        return in_turns({"": waited}, rounds=self.rounds)[""].wall

    def kernel_seconds(self, work) -> float:
        """Return the seconds that the device spends in kernels."""
        rounds = []
        for _ in range(self.rounds):
            with wp.ScopedTimer("", print=False, cuda_filter=wp.TIMING_KERNEL) as timer:
                work()
            rounds.append(sum(result.elapsed for result in timer.timing_results) / 1e3)
        return float(np.median(rounds))

    def update(self) -> None:
        def moved() -> None:
            self.scene.touch("transforms")
            self.renderer.sync()

        print(f"update of {len(self.renderer.gprims)} poses: {1e3 * self.seconds(moved):.2f} ms")

    def rays(self) -> None:
        for view in self.views:
            origins, directions = camera_rays(view)
            hits = self._trace(np.tile(origins, (CAMERAS, 1)), np.tile(directions, (CAMERAS, 1)), "primary")
            hits = hits[: len(origins)]
            met = hits["instance"] >= 0
            points = origins[met] + directions[met] * (hits["t"][met, None] * (1 - 1e-4))
            rng = np.random.default_rng(0)
            points = np.tile(points, (CAMERAS, 1))
            bounced = rng.normal(size=points.shape)
            bounced *= np.sign((bounced * np.tile(-directions[met], (CAMERAS, 1))).sum(1, keepdims=True))
            self._trace(points, bounced / np.linalg.norm(bounced, axis=1, keepdims=True), "diffuse")
            to_light = np.array([0.3, 0.2, 1.0]) - points
            far = np.linalg.norm(to_light, axis=1)
            self._trace(points, to_light / far[:, None], "shadow", far)

    def _trace(self, origins, directions, name: str, max_distance=None) -> np.ndarray:
        count = len(origins)
        arrays = [
            wp.array(np.ascontiguousarray(each, np.float32), dtype=wp.vec3, device=self.device)
            for each in (origins, directions)
        ]
        max_distances = wp.array(
            np.full(count, 1e30) if max_distance is None else max_distance, dtype=wp.float32, device=self.device
        )
        hits = wp.zeros(count, dtype=Hit, device=self.device)
        inputs = [self.renderer._on_device.tables, int(max_distance is not None), 0, *arrays, max_distances]

        def launch() -> None:
            wp.launch(trace_rays, dim=count, inputs=inputs, outputs=[hits], device=self.device, block_dim=BLOCK)

        print(f"  {name} rays: {count / self.seconds(launch) / 1e6:.0f} M/s")
        return hits.numpy()

    def paths(self) -> None:
        for view in self.views:
            film = self.renderer.new_film(view.width, view.height)

            def trace(view=view, film=film) -> None:
                self.renderer.accumulate(film, view, samples=SAMPLES, settings=PathSettings())

            seconds = self.seconds(trace)
            rate = view.width * view.height * SAMPLES / seconds / 1e6
            print(f"{view.prim_path}: {SAMPLES} spp in {seconds:.3f} s, {rate:.0f} Msamples/s")

    def labels(self) -> None:
        """Time every AOV of one ray per pixel of many views in one launch, and Newton's SensorCamera."""
        views = render_scene.many_views(self.scene, CAMERAS)
        for names in (LABELS, ("instance",)):
            seconds = self.seconds(lambda names=names: self.renderer.label_batch(views, names))
            pixels = CAMERAS * views[0].width * views[0].height
            kernels = self.kernel_seconds(lambda names=names: self.renderer.label_batch(views, names))
            rate = f"{1e3 * kernels:.2f} ms in kernels, {pixels / kernels / 1e6:.0f} M pixels/s"
            print(f"{len(names)} AOVs of {CAMERAS} views: {1e3 * seconds:.2f} ms, {rate}")
        fetched = self.seconds(lambda: self.renderer.labels_of(views, LABELS))
        print(f"{len(LABELS)} AOVs of {CAMERAS} views, fetched: {1e3 * fetched:.1f} ms")
        for order in ORDERS:
            cameras = SensorCameras(self.scene, views, self.device, order)
            seconds, kernels = self.seconds(cameras.draw), self.kernel_seconds(cameras.draw)
            what = f"SensorCamera, {CAMERAS} views, {order}"
            print(f"{what}: {1e3 * seconds:.2f} ms, {1e3 * kernels:.2f} ms in kernels")

    def many_views(self) -> None:
        """Time the labels of a small training set in one launch, with boxes and masks computed on the device."""
        views = render_scene.many_views(self.scene, MANY)
        classes = np.arange(len(self.renderer.gprims)) % 15

        def draw() -> None:
            batch = self.renderer.label_batch(views, ("instance", "distance_to_image_plane", "normals"))
            batch.masks(classes)
            batch.boxes(len(classes))

        seconds = self.seconds(draw)
        what = f"ids, depths, normals, masks and boxes of {MANY} views"
        print(f"{what}: {1e3 * seconds:.0f} ms, {MANY / seconds:.0f} views/s")

    def amodal(self) -> None:
        """Time amodal coverage of every object, in one view and in many at once, on top of the ids."""
        groups = [[k] for k in range(len(self.renderer.gprims))]
        pairs = [[k, k + 1] for k in range(0, len(groups) - 1, 2)]
        for count in (1, CAMERAS):
            views = render_scene.many_views(self.scene, count)
            batch = self.renderer.label_batch(views, ("instance",))
            for name, some in (("objects", groups), ("pairs of objects", pairs)):

                def cover(views=views, some=some, batch=batch) -> None:
                    self.renderer.coverage_batch(views, some, batch).sums()

                seconds, kernels = self.seconds(cover), self.kernel_seconds(cover)
                each = f"{1e3 * seconds / count:.2f} ms a view, {1e3 * kernels / count:.2f} in kernels"
                print(f"amodal counts and boxes of all {name}, {count} views: {each}")
        fetched = self.seconds(
            lambda: [each.words for each in self.renderer.labels_and_masks(views, ("instance",), groups)[1]]
        )
        print(f"ids and masks of all objects, {CAMERAS} views, fetched: {1e3 * fetched / CAMERAS:.2f} ms a view")

    def small_images(self) -> None:
        """Time images of many small cameras, as for reinforcement learning: together, and one by one."""
        views = [replace(self.views[k % 2], width=SMALL, height=SMALL) for k in range(SMALL_CAMERAS)]
        films = [self.renderer.new_film(SMALL, SMALL) for _ in views]
        settings = PathSettings.fast()

        def one_by_one() -> None:
            for film, view in zip(films, views, strict=True):
                self.renderer.accumulate(film, view, samples=4, settings=settings)

        together = self.seconds(lambda: self.renderer.accumulate_all(films, views, samples=4, settings=settings))
        alone = self.seconds(one_by_one)
        what = f"{SMALL_CAMERAS} images of {SMALL}x{SMALL} at 4 spp"
        print(f"{what}: {1e3 * together:.1f} ms together, {1e3 * alone:.1f} ms one by one")

    def agreement(self) -> None:
        """Print the fraction of pixels with the same ids as on the CPU, over all lenses, and how far depths differ."""
        cpu = WarpRenderer.of_scene(self.scene, device="cpu")
        cpu.sync()
        same = pixels = 0
        worst = 0.0
        for view in self.views:
            for values in CASES.values():
                lens = replace(view, **values)
                ours, theirs = (r.labels(lens, ["instance", "distance_to_camera"]) for r in (self.renderer, cpu))
                equal = ours["instance"] == theirs["instance"]
                same, pixels = same + equal.sum(), pixels + equal.size
                seen = equal & (theirs["instance"] >= 0)
                near, far = ours["distance_to_camera"][seen], theirs["distance_to_camera"][seen]
                worst = max(worst, float(np.abs(near / far - 1).max(initial=0)))
        print(f"ids as on the CPU: {same / pixels:.6%} of {pixels} pixels; depths within {worst:.1e} of theirs")

    def images(self) -> None:
        """Print how far the images of both devices differ, with glass, mirrors, a lamp, a sky and a lens."""
        films = []
        for device in (self.device, "cpu"):
            renderer = WarpRenderer.of_scene(everything(), device=device)
            renderer.sync()
            film = renderer.new_film(VIEW.width, VIEW.height)
            renderer.accumulate(film, VIEW, samples=256, settings=PathSettings(light_aovs=True))
            films.append([film.radiance(), *film.light_aovs().values()])
        apart = max(abs(ours.mean() - theirs.mean()) / theirs.mean() for ours, theirs in zip(*films, strict=True))
        print(f"mean of an image and of its parts: within {apart:.1e} of the CPU's")


def camera_rays(view: CameraView) -> tuple[np.ndarray, np.ndarray]:
    """Return rays through pixel centers in the order of the path tracer: along columns of bands of four rows."""
    y, x = np.mgrid[0 : view.height, 0 : view.width].reshape(2, view.height // 4, 4, view.width).swapaxes(2, 3)
    x, y = x.ravel() + 0.5, y.ravel() + 0.5
    toward = np.stack([(x - view.cx) / view.fx, (view.cy - y) / view.fy, -np.ones_like(x)], -1)
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    origins = np.broadcast_to(view.local_to_world[3, :3], toward.shape)
    return origins, toward @ view.local_to_world[:3, :3]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--device", default="cuda:0")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    bench = Bench(options.device, options.rounds)
    parts = [bench.update, bench.rays, bench.paths, bench.labels, bench.many_views, bench.amodal]
    for part in [*parts, bench.small_images, bench.agreement, bench.images]:
        part()


if __name__ == "__main__":
    main()
