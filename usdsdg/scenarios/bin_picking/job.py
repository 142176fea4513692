"""The bin picking job: fills the bin, then captures it from several places in several lights, drop by drop."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

import usdsdg as rep
from usdsdg.scenarios.bin_picking.bin import BinSize, StageBin, suiting
from usdsdg.scenarios.bin_picking.cameras import BinCamerasOnStage, add_cameras
from usdsdg.scenarios.bin_picking.config import BinPickingConfig
from usdsdg.scenarios.bin_picking.drop import Part, fill, make_part
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.environment import add_physics_scene
from usdsdg.scenarios.shared.bodies import add_asset
from usdsdg.scenarios.shared.decks import deal, variants
from usdsdg.scenarios.shared.lighting import Brightness, Lighting
from usdsdg.scenarios.shared.mesh_folder import MeshAsset, read_assets
from usdsdg.scenarios.shared.patterns import pattern_folder
from usdsdg.scenarios.shared.pictures import Picture, pictures_in, skies_in
from usdsdg.scenarios.shared.runs import Summary, begin, capture
from usdsdg.session import stage_context

Kind = tuple[str, int]  # class and number of the shape


@dataclass(frozen=True)
class Scene:
    """Prims of the bin picking job."""

    bin: StageBin
    parts: dict[Kind, list[Part]]
    cameras: BinCamerasOnStage
    lighting: Lighting
    pictures: list[Picture]


def run(config: BinPickingConfig) -> Summary:
    """Generate the dataset that `config` describes.

    Ctrl-C finishes the frame and its files, and raises KeyboardInterrupt.

    Raises:
        AssetError: a mesh or a sky cannot be used.
        WriterError: an option of a format has a wrong value, or its files cannot be written.
    """
    by_label, writers = begin(config, frames_per_scene=config.frames_per_drop)
    draws, assets = Draws(config.seed, "bin_picking"), read_assets(by_label, config.mesh_unit)
    hands = _hands(config, draws, assets)
    scene = build(config, hands, assets)
    products = [
        rep.create.render_product(str(camera.GetPath()), size)
        for camera, size in zip(scene.cameras.cameras, scene.cameras.sizes, strict=True)
    ]
    for _, writer in writers:
        writer.attach(products)

    def prepare(frame: int) -> None:
        drop, view = divmod(frame, config.frames_per_drop)
        if view == 0:
            _fill(scene, config, draws, drop, hands[drop])
        scene.cameras.randomize(draws, frame, scene.bin.size, config.cameras)
        scene.lighting.randomize(draws, frame)

    return capture(config.num_frames, prepare, config.rendering, views=len(products), writers=writers)


def build(config: BinPickingConfig, hands: Sequence[Sequence[Kind]], assets: Sequence[MeshAsset]) -> Scene:
    """Create the stage with as many parts of each kind as some drop has."""
    stage = stage_context.new_stage()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    add_physics_scene(stage)
    rep.orchestrator.set_capture_on_play(False)
    size = BinSize(*config.bin.size) if config.bin.size else suiting(assets, config.parts.per_bin[1])
    pictures = pictures_in(config.table or pattern_folder())
    brightness = Brightness(config.lights.sky, config.lights.lamps, config.lights.lamp_count)
    return Scene(
        StageBin(stage, size, config.bin.thickness, pictures[0]),
        _parts(stage, config, hands, assets),
        add_cameras(stage, config.cameras, config.resolution, size.radius),
        Lighting(stage, skies_in(config.skies), brightness),
        pictures,
    )


def _parts(
    stage: Usd.Stage, config: BinPickingConfig, hands: Sequence[Sequence[Kind]], assets: Sequence[MeshAsset]
) -> dict[Kind, list[Part]]:
    most: Counter[Kind] = Counter()
    for hand in hands:
        most |= Counter(hand)
    parent, parts, shapes = stage.DefinePrim("/World/Parts", "Xform"), {}, Counter()
    for asset in assets:
        kind = asset.label, shapes[asset.label]
        shapes[asset.label] += 1
        made = [make_part(add_asset(parent, asset, labeled=True), config.parts.collider) for _ in range(most[kind])]
        parts[kind] = made
    return parts


def _hands(config: BinPickingConfig, draws: Draws, assets: Sequence[MeshAsset]) -> list[list[Kind]]:
    """Return the parts of each drop by class and number of the shape."""
    low, high = config.parts.per_bin
    counts = [int(draws.generator("count", drop).integers(low, high + 1)) for drop in range(config.drops)]
    shares = dict.fromkeys((asset.label for asset in assets), 1.0)
    if config.parts.classes == "one":
        chosen = deal(draws, [1] * config.drops, shares)
        hands = [[hand[0]] * count for hand, count in zip(chosen, counts)]
    else:
        hands = deal(draws, counts, shares)
    return variants(hands, Counter(asset.label for asset in assets))


def _fill(scene: Scene, config: BinPickingConfig, draws: Draws, drop: int, hand: Sequence[Kind]) -> None:
    """Empty the bin, draw colors and table, and drop the parts of a hand."""
    for part in (part for parts in scene.parts.values() for part in parts):
        part.enable(False)
    generator = draws.generator("bin", drop)
    scene.bin.paint(generator)
    picture = scene.pictures[int(np.asarray(generator.integers(len(scene.pictures))))]
    scene.bin.table.show(picture, generator)
    free = {kind: list(parts) for kind, parts in scene.parts.items()}
    fill(scene.bin, [free[kind].pop() for kind in hand], draws.generator("drop", drop), max_time=config.parts.max_time)
