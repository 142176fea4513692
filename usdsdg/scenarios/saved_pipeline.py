"""Run the graph of a saved stage again, without the script that made it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from usdsdg import orchestrator
from usdsdg.app import saved_graph
from usdsdg.arguments.registry import near_misses
from usdsdg.create.render_products import HydraTexture, render_product, render_product_tiled
from usdsdg.errors import ConfigError, GraphError
from usdsdg.graph.evaluate import Trigger, graph
from usdsdg.graph.sampling import set_global_seed
from usdsdg.scenarios.output_folder import with_absolute_output_dir
from usdsdg.session import stage_context
from usdsdg.session.confinement import confined
from usdsdg.session.settings.store import get_settings
from usdsdg.stores.addresses import is_url
from usdsdg.writers import WriterRegistry
from usdsdg.writers.backends.disk import disk_root
from usdsdg.writers.base import ON_FRAME

SUFFIXES = (".usd", ".usda", ".usdc")


@dataclass(frozen=True)
class Overrides:
    """Options that override those of the saved stage; None keeps the stage's."""

    num_frames: int | None = None
    output_dir: str | None = None
    seed: int | None = None

    @classmethod
    def parse(cls, assignments: list[str]) -> Overrides:
        """Parse `key=value` strings.

        Raises:
            ConfigError: unknown keys or values of the wrong type; one message names all of them.
        """
        readers = {"num_frames": int, "output_dir": str, "seed": int}
        values: dict[str, Any] = {}
        problems = []
        for assignment in assignments:
            key, _, text = assignment.partition("=")
            if key not in readers:
                near = near_misses(key, readers) or list(readers)
                problems.append(f"{key}: a saved stage has no such key; it has {', '.join(near)}")
                continue
            try:
                values[key] = readers[key](text)
            except ValueError:
                problems.append(f"{key}: {text!r} is not a whole number")
        if problems:
            raise ConfigError("; ".join(problems))
        return cls(**values)


def run(stage_file: Path, overrides: Overrides, *, allow_outside: bool = False) -> None:
    """Open the stage, restore its graph, render products and writers, and capture its frames.

    allow_outside: whether the stage may say that output goes elsewhere than below the root of relative folders.

    Raises:
        GraphError: the stage holds no graph, no writer, or nodes that need Python code.
        OutputNotWritable: it says that output goes elsewhere.
    """
    stage = stage_context.open_stage(stage_file)
    saved = saved_graph.load(stage)
    set_global_seed(saved.seed if overrides.seed is None else overrides.seed)
    if not saved.writers:
        raise GraphError(f"{stage_file} names no writer; attach one in the script before the stage is saved")
    with confined(None if allow_outside else _limit(overrides)):
        for key, value in saved.settings.items():
            get_settings().set(key, value)
        made = _make_products(saved.writers)
        for writer in saved.writers:
            _attach(writer, made, overrides)
    frames = overrides.num_frames or saved.frames
    if not frames:
        raise GraphError(f"{stage_file} was saved before its first capture; say how many: --set num_frames=10")
    orchestrator.get_orchestrator().expect_frames(frames)
    for _ in range(frames):
        orchestrator.step(rt_subframes=saved.rt_subframes or -1)
    orchestrator.wait_until_complete()


def _limit(overrides: Overrides) -> Path | None:
    """Return below which folder output goes; None where the user has named a bucket."""
    if overrides.output_dir is None:
        return disk_root()
    given = with_absolute_output_dir({"output_dir": overrides.output_dir})["output_dir"]
    return None if is_url(given) else Path(given)


def _make_products(writers: list[saved_graph.SavedWriter]) -> dict[str, HydraTexture]:
    """Make the render products of all writers, each once and with its name, after which folders are called."""
    stage, made = stage_context.current_stage(), {}
    wanted = {path: each for writer in writers for path, each in writer.products.items()}
    for path in wanted:
        stage.RemovePrim(path)  # a saved stage has the prims, too, so that their names would be taken
    for path, (camera, size) in wanted.items():
        make = render_product_tiled if isinstance(camera, list) else render_product
        made[path] = make(camera, size, name=path.rsplit("/", 1)[-1])
    return made


def _attach(saved: saved_graph.SavedWriter, made: dict[str, HydraTexture], overrides: Overrides) -> None:
    arguments = dict(saved.arguments)
    if overrides.output_dir is not None:
        arguments = with_absolute_output_dir({**arguments, "output_dir": overrides.output_dir})
    writer = WriterRegistry.get(saved.name)
    writer.initialize(**arguments)
    writer.attach([made[path] for path in saved.products], trigger=_trigger_at(saved) if saved.trigger else ON_FRAME)


def _trigger_at(saved: saved_graph.SavedWriter) -> Trigger:
    for each in graph().triggers:
        if each.node.path == saved.trigger:
            return each
    raise GraphError(f"{saved.trigger}, at which the {saved.name} of the stage is due, is no trigger of its graph")
