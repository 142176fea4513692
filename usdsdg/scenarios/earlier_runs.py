"""Which earlier runs of a configuration, or of a saved stage, are the wanted one with fewer frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from usdsdg.errors import UsdsdgError, counted
from usdsdg.scenarios.jobs import Job, load_job
from usdsdg.scenarios.saved_pipeline import Overrides
from usdsdg.writers.journal.growth import Obstacle, differing, fewer
from usdsdg.writers.journal.recipe import SOURCE, Recipe, source_of


def of_job(file: Path, job: Job, config: Any) -> Obstacle:
    """Return what keeps an earlier run of a job from being the first frames of one.

    What counts is what the configurations mean, whether a key is in the file or given with --set.
    """

    def obstacle(wanted: Recipe, earlier: Recipe, folder: Path) -> str | None:
        if differing(wanted, earlier) - {"arguments", "source"} or wanted.source["name"] != earlier.source["name"]:
            return None
        source = file if wanted.source == earlier.source else folder / SOURCE / earlier.source["name"]
        try:
            if source_of(source)["sha256"] != earlier.source["sha256"]:
                return None
            own, before = load_job(source, earlier.arguments)
        except (OSError, UsdsdgError):
            return None  # it is not known what the earlier run was
        if own is not job or _meaning(before, job) != _meaning(config, job):
            return None
        then, now = getattr(before, job.count), getattr(config, job.count)
        if then == now:
            return None
        if now < then:
            return fewer(f"{job.count}={then}", f"{job.count}={now}")
        return job.obstacle(before, config)

    return obstacle


def of_stage(wanted: Recipe, earlier: Recipe, folder: Path) -> str | None:
    """Return what keeps an earlier run of a saved stage from being the first frames of one; see `Obstacle`."""
    if differing(wanted, earlier) != {"arguments"}:
        return None
    try:
        now, then = (Overrides.parse(each.arguments) for each in (wanted, earlier))
    except UsdsdgError:
        return None
    count, before = now.num_frames, then.num_frames or earlier.frames
    if now.seed != then.seed or not count or not before or count == before:
        return None
    return fewer(counted(before, "frame"), f"num_frames={count}") if count < before else ""


def _meaning(config: Any, job: Job) -> dict[str, Any]:
    """Return what a configuration says, apart from the number of frames and from where files go."""
    values = _placeless(config.model_dump())
    del values[job.count]
    return values


def _placeless(values: Any) -> Any:
    if isinstance(values, dict):
        return {key: _placeless(value) for key, value in values.items() if key != "output_dir"}
    return [_placeless(each) for each in values] if isinstance(values, list | tuple) else values
