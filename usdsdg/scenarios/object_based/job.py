"""Object-based scenario: labeled objects and distractors in a closed box, captured by cameras that follow the objects.

The steps and their order are those of Isaac Sim's object-based example; random numbers are keyed draws of our own.
"""

import gc
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.errors import AssetError, AssetNotFound, Unsupported, counted, warnings_remembered
from usdsdg.graph.sampling import set_global_seed
from usdsdg.orchestrator import get_orchestrator
from usdsdg.scenarios import environment
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.episodes import Episode, can_be_passed_over, episodes
from usdsdg.scenarios.object_based import cameras, capture_loop, objects, randomizers
from usdsdg.scenarios.object_based.capture_loop import Scene
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.scenarios.output_folder import with_absolute_output_dir
from usdsdg.scenarios.shared.runs import frames_made
from usdsdg.session import engines
from usdsdg.session.render_products import products
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline
from usdsdg.stage import assets
from usdsdg.writers import Writer
from usdsdg.writers.journal.run import get_run


@dataclass(frozen=True)
class Summary:
    """Result of a run. `output_dir` is None for a writer without one."""

    frames: int
    images: int
    seconds: float
    simulated_seconds: float
    output_dir: str | None


def run(config: ObjectBasedConfig) -> Summary:
    """Build the scene and capture the dataset that `config` describes.

    Ctrl-C finishes the frame and its files, says where they are, and raises KeyboardInterrupt.

    Raises:
        AssetNotFound: assets are missing; one message names all of them.
        WriterError: the writer is unknown, its arguments are wrong, or its files cannot be written.
    """
    # Fail on missing assets and wrong writer options before any work is done.
    check_assets(config)
    if config.semantic_classes is not None:
        rep.settings.set_semantic_classes(config.semantic_classes)
    capture_loop.apply_render_settings(config)
    writer = make_writer(config)
    engines.compile_renderer_beside()
    started, frames, simulated = time.perf_counter(), 0, 0.0
    planned = episodes(config.seed, config.num_frames, config.frames_per_episode)
    with warnings_remembered():  # all episodes are of one configuration
        for episode in planned:
            if len(planned) > 1 and can_be_passed_over([writer] if writer else [], episode):
                _pass_over(config, episode, writer)
                frames = episode.first + episode.frames
                continue
            captured, seconds = _run_episode(config, episode, writer)
            frames, simulated = episode.first + captured, simulated + seconds
            if captured < episode.frames or get_run().is_over:
                break
            if len(planned) > 1:
                gc.collect()  # the scene that was, which refers to itself, and would stay for some episodes more
    frames = config.num_frames if get_run().is_over else frames
    seconds = time.perf_counter() - started
    summary = Summary(frames, frames * config.num_cameras, seconds, simulated, _output_dir(writer))
    if current().tap is None:  # else nothing was written
        _print_summary(summary, config.num_cameras)
    if frames < config.num_frames:
        raise KeyboardInterrupt
    return summary


def _run_episode(config: ObjectBasedConfig, episode: Episode, writer: Writer | None) -> tuple[int, float]:
    """Build, simulate and capture an episode; return how many frames were captured, and the simulated seconds."""
    set_global_seed(episode.seed)
    draws = Draws(episode.seed)
    scene = build_scene(config, draws)
    _attach(writer, scene)
    stop_bouncing = add_randomizers(config, scene, draws)

    if config.settle:
        rep.physics.simulate_until_rest()
    capture_loop.start_timeline()
    get_orchestrator().expect_frames(config.num_frames, before=episode.first)
    try:
        frames = capture_loop.capture_frames(config, scene, draws, episode.frames)
    finally:
        stop_bouncing()
        rep.orchestrator.wait_until_complete()

    simulated = get_timeline().get_current_time()
    get_app().update()
    get_timeline().stop()
    return frames, simulated


def _pass_over(config: ObjectBasedConfig, episode: Episode, writer: Writer | None) -> None:
    """Count the frames of an episode that this process does not make."""
    set_global_seed(episode.seed)
    if writer is not None and not writer.render_products:
        _attach(writer, build_scene(config, Draws(episode.seed)))
    toggled = products() if config.disable_render_products_between_captures else []
    capture_loop.set_updates(toggled, True)
    get_orchestrator().pass_over(episode.frames)
    capture_loop.set_updates(toggled, False)


def _attach(writer: Writer | None, scene: Scene) -> None:
    if writer is not None and scene.render_products:
        writer.attach(scene.render_products)


def check_assets(config: ObjectBasedConfig) -> None:
    """Check that every asset exists.

    Raises:
        AssetNotFound: the assets root is no folder, or assets are missing; one message names all of them and why.
    """
    assets.assets_root()
    objects = {asset.url for asset in config.labeled_assets_and_properties if asset.count}
    objects.update(config.mesh_distractors_urls if config.mesh_distractors_wanted else [])
    urls = {*objects, *randomizers.DOME_TEXTURES, *([config.env_url] if config.env_url else [])}
    missing = []
    for url in sorted(urls):
        try:
            assets.resolve_object(url) if url in objects else assets.resolve(url)
        except (AssetError, Unsupported) as error:
            missing.append(str(error))
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        count = f"{len(missing)} of {counted(len(urls), 'asset')} {verb} missing or damaged:"
        raise AssetNotFound("\n  ".join([count, *missing]))


def build_scene(config: ObjectBasedConfig, draws: Draws) -> Scene:
    """Create environment, walls, physics scene, objects, cameras and render products, in this order."""
    stage = environment.open_environment(config.env_url)
    environment.add_walls(stage, config.working_area_size)
    physics_scene = environment.add_physics_scene(stage)
    labeled = objects.add_labeled_assets(stage, config, draws)
    shapes = objects.add_shape_distractors(stage, config, draws)
    meshes = objects.add_mesh_distractors(stage, config, draws)
    rep.orchestrator.set_capture_on_play(False)
    scene_cameras = cameras.add_cameras(stage, config)
    get_app().update()
    products = [rep.create.render_product(str(prim.GetPath()), config.resolution) for prim in scene_cameras.prims]
    if config.disable_render_products_between_captures:
        capture_loop.set_updates(products, False)
    return Scene(stage, physics_scene, labeled, shapes, meshes, scene_cameras, products)


def make_writer(config: ObjectBasedConfig) -> Writer | None:
    """Return the initialized writer, not attached yet; None where the configuration names none.

    Raises:
        WriterError: the writer is unknown, its arguments are wrong, or its folder cannot be written to.
    """
    if config.writer_type is None:
        print("no writer_type in the config: frames are captured, but nothing is written", file=sys.stderr)
        return None
    return rep.writers.get(config.writer_type, init_params=with_absolute_output_dir(config.writer_kwargs))


def add_randomizers(config: ObjectBasedConfig, scene: Scene, draws: Draws) -> Callable[[], None]:
    """Register randomizers on events and bouncing at the floor; return a function that ends the bouncing."""
    stop_bouncing = randomizers.bounce_at_floor(scene.stage, config, draws)
    randomizers.add_color_randomizer(scene.shapes.all)
    randomizers.add_velocity_randomizer([*scene.shapes.floating, *scene.meshes.floating])
    randomizers.add_light_randomizer(config)
    randomizers.add_background_randomizer()
    return stop_bouncing


def _output_dir(writer: Writer | None) -> str | None:
    return getattr(writer.backend, "output_dir", None) if writer is not None else None


def _print_summary(summary: Summary, views: int) -> None:
    if not summary.images:
        print("nothing was captured: num_frames or num_cameras is 0", file=sys.stderr)
        return
    made = get_run().made
    rate = made / summary.seconds if summary.seconds > 0 else 0.0
    print(
        f"{frames_made(summary.frames)}, {counted(made * views, 'view')} in {summary.seconds:.1f} s "
        f"({rate:.2f} frames/s, {summary.simulated_seconds:.2f} s simulated)"
    )
    if summary.output_dir:
        print(f"dataset: {summary.output_dir}")
