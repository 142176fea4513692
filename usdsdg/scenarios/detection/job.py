"""The detection job: builds the scene, then arranges, lights and captures each frame by itself."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pxr import Gf

from usdsdg.scenarios.detection.arrangement import Arranger
from usdsdg.scenarios.detection.config import DetectionConfig
from usdsdg.scenarios.detection.scene import Scene, build, sizes_of
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.shared.bodies import Body
from usdsdg.scenarios.shared.decks import deal, most_of_each, variants
from usdsdg.scenarios.shared.mesh_folder import read_assets
from usdsdg.scenarios.shared.runs import Arranged, Summary, begin, capture
from usdsdg.session import engines
from usdsdg.stage.poses.xform_ops import author_pose

# The camera looks down rather than up; degrees from the horizon, and of roll.
_PITCH, _ROLL = (-70.0, 15.0), 12.0
# The backdrop is this much farther than the farthest thing.
_BEHIND = 1.15


def run(config: DetectionConfig) -> Summary:
    """Generate the dataset that `config` describes.

    Ctrl-C finishes the frame and its files, and raises KeyboardInterrupt.

    Raises:
        AssetError: a mesh or a sky cannot be used.
        WriterError: an option of a format has a wrong value, or its files cannot be written.
    """
    by_label, writers = begin(config)
    draws, assets = Draws(config.seed, "detection"), read_assets(by_label, config.mesh_unit)
    hands = _hands(config, draws, list(by_label), sizes_of(assets))
    scene = build(config, hands, assets)
    arranger = Arranger(config, draws, scene.seen, scene.camera)
    engines.renderer().sync()  # reads all meshes now, while all are shown
    for _, writer in writers:
        writer.attach([scene.product])

    def prepare(frame: int) -> None:
        _turn_view(scene, draws, frame)
        objects, distractors = _chosen(scene, config, draws, frame, hands[frame])
        scene.lighting.randomize(draws, frame)
        _hide_all(scene)
        far = arranger.arrange(frame, objects, distractors)
        _choose_background(scene, config, draws, frame, far * _BEHIND)

    arranged = [Arranged(range(config.num_frames), prepare)]
    return capture(config.num_frames, arranged, config.rendering, views=1, writers=writers)


def obstacle(earlier: DetectionConfig, wanted: DetectionConfig) -> str:
    """Return why a job has another stage than one with more frames; "" if it is the same."""
    by_label = {label: len(files) for label, files in wanted.files().items()}
    draws = Draws(wanted.seed, "detection")
    then, now = (most_of_each(_hands(each, draws, list(by_label), by_label)) for each in (earlier, wanted))
    if then == now:
        return ""
    label = min(shape for shape in now if now[shape] != then[shape])[0]
    return (
        "the stage has as many copies of each shape as one frame shows at most, and with more frames there are more "
        f"copies, such as of {label}, so that ids in the earlier frames would be others"
    )


def _hands(
    config: DetectionConfig, draws: Draws, classes: list[str], available: Mapping[str, int]
) -> list[list[tuple[str, int]]]:
    """Return the objects of each frame, by class and number of the shape. available: the shapes of each class."""
    return variants(deal(draws, _counts(config, draws), _shares(config, classes)), available)


def _counts(config: DetectionConfig, draws: Draws) -> list[int]:
    low, high = config.objects.per_image
    return [int(draws.generator("count", frame).integers(low, high + 1)) for frame in range(config.num_frames)]


def _shares(config: DetectionConfig, classes: list[str]) -> dict[str, float]:
    balance = config.objects.class_balance
    if isinstance(balance, str):
        return dict.fromkeys(classes, 1.0)
    given = {name.lower(): share for name, share in balance.items()}
    return {name: given[name] for name in classes}


def _turn_view(scene: Scene, draws: Draws, frame: int) -> None:
    """Look in a random direction of the world, which decides from where light comes and what of the sky is seen."""
    generator = draws.generator("view", frame)
    pitch, roll, yaw = generator.uniform(*_PITCH), generator.uniform(-_ROLL, _ROLL), generator.uniform(0.0, 360.0)
    # A camera prim looks along -Z: 90 degrees about X is the horizon of a Z-up stage. Roll comes first.
    turns = [
        Gf.Rotation(Gf.Vec3d(*axis), angle)
        for axis, angle in (((0, 0, 1), roll), ((1, 0, 0), 90.0 + pitch), ((0, 0, 1), yaw))
    ]
    author_pose(scene.view, orient=(turns[0] * turns[1] * turns[2]).GetQuat())


def _chosen(
    scene: Scene, config: DetectionConfig, draws: Draws, frame: int, hand: list[tuple[str, int]]
) -> tuple[list[Body], list[Body]]:
    """Return the objects of a frame, and its distractors in random order."""
    used: dict[tuple[str, int], int] = {}
    objects = []
    for kind in hand:
        objects.append(scene.objects[kind][used.get(kind, 0)])
        used[kind] = used.get(kind, 0) + 1
    generator, (low, high) = draws.generator("distractors", frame), config.distractors.per_image
    count = min(int(generator.integers(low, high + 1)), len(scene.distractors))
    return objects, [scene.distractors[index] for index in generator.permutation(len(scene.distractors))[:count]]


def _hide_all(scene: Scene) -> None:
    for body in (*(body for bodies in scene.objects.values() for body in bodies), *scene.distractors):
        body.show(False)
    if scene.backdrop is not None:
        scene.backdrop.hide()


def _choose_background(scene: Scene, config: DetectionConfig, draws: Draws, frame: int, distance: float) -> None:
    generator = draws.generator("background", frame)
    if scene.backdrop is None or generator.random() >= config.backgrounds.share_of_pictures:
        return
    picture = scene.pictures[_picture_of(draws, frame, len(scene.pictures))]
    scene.backdrop.show(picture, distance, generator)


def _picture_of(draws: Draws, frame: int, count: int) -> int:
    """Return the picture of a frame: all take turns in a shuffled order, so that many frames show many pictures."""
    deck, place = divmod(frame, count)
    return int(np.asarray(draws.generator("pictures", deck).permutation(count))[place])
