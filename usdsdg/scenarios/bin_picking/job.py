"""The bin picking job: fills the bin, then captures it from several places in several lights, drop by drop."""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from usdsdg.errors import warnings_remembered
from usdsdg.graph.sampling import set_global_seed
from usdsdg.orchestrator import get_orchestrator
from usdsdg.scenarios.bin_picking.bin import StageBin, given, suiting
from usdsdg.scenarios.bin_picking.cameras import BinCamerasOnStage, add_cameras
from usdsdg.scenarios.bin_picking.config import BinPickingConfig
from usdsdg.scenarios.bin_picking.drop import Part, fill, make_part
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.environment import add_physics_scene
from usdsdg.scenarios.episodes import can_be_passed_over, episodes
from usdsdg.scenarios.shared.bodies import add_asset
from usdsdg.scenarios.shared.decks import deal, variants
from usdsdg.scenarios.shared.lighting import Brightness, Lighting
from usdsdg.scenarios.shared.mesh_folder import MeshAsset, read_assets
from usdsdg.scenarios.shared.patterns import pattern_folder
from usdsdg.scenarios.shared.pictures import Picture, pictures_in, skies_in
from usdsdg.scenarios.shared.runs import Arranged, Summary, begin, capture
from usdsdg.session import engines, stage_context
from usdsdg.writers import Writer

Kind = tuple[str, int]  # class and number of the shape


@dataclass(frozen=True)
class Scene:
    """Prims of the bin picking job."""

    bin: StageBin
    parts: list[Part]
    cameras: BinCamerasOnStage
    lighting: Lighting
    pictures: list[Picture]


def run(config: BinPickingConfig) -> Summary:
    """Generate the dataset that `config` describes.

    Ctrl-C finishes the frame and its files, and raises KeyboardInterrupt.

    Raises:
        ConfigError: bin.size is far too large for the parts.
        AssetError: a mesh or a sky cannot be used.
        WriterError: an option of a format has a wrong value, or its files cannot be written.
    """
    by_label, writers = begin(config, frames_per_scene=config.frames_per_drop)
    engines.compile_renderer_beside()
    assets = read_assets(by_label, config.mesh_unit)
    with warnings_remembered():  # all drops are of one configuration
        views = _survey(config, assets, [writer for _, writer in writers])
        drops = _drops(config, assets, [writer for _, writer in writers])
        return capture(config.num_frames, drops, config.rendering, views=views, writers=writers)


def _survey(config: BinPickingConfig, assets: Sequence[MeshAsset], writers: Sequence[Writer]) -> int:
    """Show the writers a stage with one part of each kind; return the number of pictures of a frame.

    It stays for drops that are passed over.
    """
    scene = build(config, kinds_of(assets), assets)
    for part in scene.parts:
        part.body.place(np.zeros(3), Gf.Quatd(1.0))  # which gives it its size
    _attach(scene, writers)
    for writer in writers:
        writer.survey()
    return len(scene.cameras.cameras)


def _drops(config: BinPickingConfig, assets: Sequence[MeshAsset], writers: Sequence[Writer]) -> Iterator[Arranged]:
    """Build a stage for each drop of which this process makes a frame, fill the bin, and yield its frames."""
    draws = Draws(config.seed, "bin_picking")
    hands = _hands(config, draws, assets)
    planned = episodes(config.seed, config.num_frames, config.frames_per_episode, "bin_picking")
    for drop, episode in enumerate(planned):
        set_global_seed(episode.seed)
        if len(planned) > 1 and can_be_passed_over(writers, episode):
            get_orchestrator().pass_over(episode.frames)
            continue
        scene = build(config, hands[drop], assets)
        _attach(scene, writers)
        _fill(scene, config, draws, drop)
        yield Arranged(range(episode.first, episode.first + episode.frames), partial(_look, scene, config, draws))
        del scene
        gc.collect()  # its stage, which refers to itself, and would stay for some drops more


def _attach(scene: Scene, writers: Sequence[Writer]) -> None:
    products = [
        rep.create.render_product(str(camera.GetPath()), size)
        for camera, size in zip(scene.cameras.cameras, scene.cameras.sizes, strict=True)
    ]
    for writer in writers:
        writer.attach(products)


def _look(scene: Scene, config: BinPickingConfig, draws: Draws, frame: int) -> None:
    """Place the cameras, and light the bin."""
    scene.cameras.randomize(draws, frame, scene.bin.size, config.cameras)
    scene.lighting.randomize(draws, frame)


def build(config: BinPickingConfig, hand: Sequence[Kind], assets: Sequence[MeshAsset]) -> Scene:
    """Create a stage with an empty bin and the parts of a hand, in its order."""
    stage = stage_context.new_stage()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    add_physics_scene(stage)
    rep.orchestrator.set_capture_on_play(False)
    size = given(config.bin.size, assets) if config.bin.size else suiting(assets, config.parts.per_bin[1])
    pictures = pictures_in(config.table or pattern_folder())
    brightness = Brightness(config.lights.sky, config.lights.lamps, config.lights.lamp_count)
    return Scene(
        StageBin(stage, size, config.bin.thickness, pictures[0]),
        _parts(stage, config, hand, assets),
        add_cameras(stage, config.cameras, config.resolution, size.radius),
        Lighting(stage, skies_in(config.skies), brightness),
        pictures,
    )


def _parts(stage: Usd.Stage, config: BinPickingConfig, hand: Sequence[Kind], assets: Sequence[MeshAsset]) -> list[Part]:
    parent, by_kind = stage.DefinePrim("/World/Parts", "Xform"), dict(zip(kinds_of(assets), assets, strict=True))
    return [make_part(add_asset(parent, by_kind[kind], labeled=True), config.parts.collider) for kind in hand]


def kinds_of(assets: Sequence[MeshAsset]) -> list[Kind]:
    """Return the kind of each asset: its class, and which one of that class it is."""
    shapes: Counter[str] = Counter()
    found = []
    for asset in assets:
        found.append((asset.label, shapes[asset.label]))
        shapes[asset.label] += 1
    return found


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


def _fill(scene: Scene, config: BinPickingConfig, draws: Draws, drop: int) -> None:
    """Draw colors and table, and drop the parts."""
    generator = draws.generator("bin", drop)
    scene.bin.paint(generator)
    picture = scene.pictures[int(np.asarray(generator.integers(len(scene.pictures))))]
    scene.bin.table.show(picture, generator)
    fill(scene.bin, scene.parts, draws.generator("drop", drop), max_time=config.parts.max_time)
