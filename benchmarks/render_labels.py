"""The label pass compared with Newton's SensorCamera, and the additional time of amodal masks of all objects.

    python -m benchmarks.render_labels [--rounds 7] [--quick]

Ours renders every AOV of one ray per pixel, motion vectors and base color included; SensorCamera renders color with
texture and one shadow, distance, normals and ids. Both render two views on one thread.
"""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks import peers, render_scene, report
from benchmarks.timing import in_turns
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.labels.aov import AOVS
from usdsdg_render.renderer import WarpRenderer

# Without the AOVs that read all textures of a material, or trace rays of their own.
LABELS = tuple(name for name, aov in AOVS.items() if aov.reads not in ("material", "hemisphere"))
AT_LEAST, AMODAL_AT_MOST = 4.0, 0.4


def labels_of(renderer: WarpRenderer, views: list[CameraView]) -> np.ndarray:
    """Return the distances of all views; the other labels are released, as a frame's are once they are written."""
    return np.stack([labels["distance_to_camera"] for labels in renderer.labels_of(views, LABELS)])


def instances_of(renderer: WarpRenderer, views: list[CameraView]) -> None:
    renderer.labels_of(views, ["instance"])


def amodal_of(renderer: WarpRenderer, views: list[CameraView], instances: list[np.ndarray]) -> None:
    """Compute amodal and modal masks of every object, given the instance labels."""
    groups = [[k] for k in range(len(renderer.gprims))]
    for view, instance in zip(views, instances, strict=True):
        renderer.pixel_masks(view, groups, instance=instance)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--quick", action="store_true", help="images of 160x120")
    options = parser.parse_args()
    report.begin()
    scene = render_scene.build()
    views = render_scene.views(scene, (160, 120) if options.quick else (640, 480))
    renderer = WarpRenderer.of_scene(scene, device="cpu")
    renderer.threads = 1
    renderer.sync()
    instances = [labels["instance"] for labels in renderer.labels_of(views, ["instance"])]
    contenders = {
        "labels": lambda _: labels_of(renderer, views),
        "instance alone": lambda _: instances_of(renderer, views),
        "amodal": lambda _: amodal_of(renderer, views, instances),
    }
    if peers.installed("newton"):
        from benchmarks.sensor_camera import SensorCameras

        cameras = SensorCameras(scene, views)
        contenders["newton"] = lambda _: cameras.render().copy()
    timings = in_turns(contenders, rounds=options.rounds)

    million = sum(view.width * view.height for view in views) / 1e6
    cpu = {name: each.cpu for name, each in timings.items()}
    rate = f"{million / cpu['labels']:.2f} Mpixel/CPU-s"
    print(f"{len(views)} views of {views[0].width}x{views[0].height}: {', '.join(LABELS)}")
    if "newton" in cpu:
        peer, ratio = f"SensorCamera {million / cpu['newton']:.2f}", cpu["newton"] / cpu["labels"]
        report.row("labels", rate, peer, ratio=ratio, target=f"at least {AT_LEAST:g}x")
        print_agreement(timings["labels"].results[-1], timings["newton"].results[-1])
    else:
        report.row("labels", rate, peers.NO_PEER)
    report.row("instance alone", f"{million / cpu['instance alone']:.2f} Mpixel/CPU-s")
    fraction = cpu["amodal"] / cpu["labels"]
    milliseconds = f"{1e3 * cpu['amodal']:.0f} ms"
    report.row("amodal, all objects", milliseconds, target=f"adds {fraction:.0%}, at most {AMODAL_AT_MOST:.0%}")


def print_agreement(distance: np.ndarray, theirs: np.ndarray) -> None:
    """Print how well the distances (views, H, W) of both agree."""
    both = np.isfinite(distance) & (theirs > 0)
    one = np.isfinite(distance) != (theirs > 0)
    alike = np.abs(distance[both] - theirs[both]) < 1e-3 * distance[both]
    print(
        f"    {both.mean():.1%} of pixels are hit in both, {one.mean():.2%} in one; {alike.mean():.2%} at one distance"
    )


if __name__ == "__main__":
    main()
