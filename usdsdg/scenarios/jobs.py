"""Which scenario a configuration is for: its key `job`, without which it is the object-based one."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from usdsdg.errors import ConfigError
from usdsdg.scenarios import episodes
from usdsdg.scenarios.bin_picking import job as bin_picking
from usdsdg.scenarios.bin_picking.config import BinPickingConfig
from usdsdg.scenarios.config_errors import suggestion
from usdsdg.scenarios.config_file import read_config, read_values
from usdsdg.scenarios.detection import job as detection
from usdsdg.scenarios.detection.config import DetectionConfig
from usdsdg.scenarios.object_based import job as object_based
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.scenarios.shared.runs import begin
from usdsdg.writers import Writer
from usdsdg.writers.spool import place_of

KEY = "job"


@dataclass(frozen=True)
class Job:
    """A scenario: the model of its configuration, and what runs it."""

    model: type[Any]
    run: Callable[[Any], Any]
    writers: Callable[[Any], Sequence[Writer]]  # those of a run, not attached
    count: str  # the key of the number of frames
    # What keeps the frames of one configuration, the first, from being the first frames of one with more; "" nothing.
    obstacle: Callable[[Any, Any], str]

    def places(self, config: Any) -> list[str]:
        """Return the folders and URLs that a run writes to.

        Raises:
            WriterError: an option of a writer has a wrong value, or a folder cannot be written to.
            DatasetInTheWay: another run is there.
        """
        found = [place_of(each.backend) for each in self.writers(config) if each.backend is not None]
        return [place for place in dict.fromkeys(found) if place is not None]

    def episode(self, config: Any) -> int:
        """Return the number of frames of an episode; 1 where all frames are one, which any cut divides alike."""
        return config.frames_per_episode or 1


def _of_object_based(config: ObjectBasedConfig) -> list[Writer]:
    writer = object_based.make_writer(config)
    return [] if writer is None else [writer]


def _of_bin_picking(config: BinPickingConfig) -> list[Writer]:
    return [writer for _, writer in begin(config, frames_per_scene=config.frames_per_drop)[1]]


def _of_detection(config: DetectionConfig) -> list[Writer]:
    return [writer for _, writer in begin(config)[1]]


JOBS = {
    "object_based": Job(ObjectBasedConfig, object_based.run, _of_object_based, "num_frames", episodes.obstacle),
    "bin_picking": Job(BinPickingConfig, bin_picking.run, _of_bin_picking, "drops", episodes.obstacle),
    "detection": Job(DetectionConfig, detection.run, _of_detection, "num_frames", detection.obstacle),
}


def keys_of_jobs() -> dict[str, list[str]]:
    """Return the keys of all configurations, each with the jobs that have it."""
    found: dict[str, list[str]] = {}
    for name, job in JOBS.items():
        for key in job.model.model_fields:
            found.setdefault(key, []).append(name)
    return found


def load_job(path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> tuple[Job, Any]:
    """Return the job of a configuration file, and its configuration with "key=value" overrides applied.

    Raises:
        ConfigError: the job is not known, or as `read_config`.
    """
    values = read_values(path, overrides)
    name = values.get(KEY)
    if name is None:
        _check_that_no_job_is_meant(path, list(values))
        return JOBS["object_based"], read_config(path, overrides, ObjectBasedConfig)
    known = [each for each in JOBS if each != "object_based"]
    if name not in known:
        hint = suggestion(str(name), known) or f"; there are {', '.join(known)}"
        raise ConfigError(f"{path}: {KEY}: {name!r} is not known{hint}")
    return JOBS[name], read_config(path, overrides, JOBS[name].model)


def _check_that_no_job_is_meant(path: str | os.PathLike[str], keys: list[str]) -> None:
    """Check that a file without the key `job` has not only keys of others than the object-based scenario.

    Raises:
        ConfigError: it has, so the key was forgotten.
    """
    known = keys_of_jobs()
    of_others = [key for key in keys if key in known and "object_based" not in known[key]]
    if of_others and not any(known.get(key) == ["object_based"] for key in keys):
        jobs = " or ".join(f"`{KEY}: {name}`" for name in known[of_others[0]])
        raise ConfigError(f"{path} has no key {KEY}, but {', '.join(of_others)}: add {jobs}")
