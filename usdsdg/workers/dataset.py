"""A dataset that several processes make: the parts that are missing are made, and all are joined."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from usdsdg.errors import BadValue
from usdsdg.session.session import current
from usdsdg.workers import local, ray_cluster
from usdsdg.workers.plan import Part, drop_others, plan
from usdsdg.workers.progress import PartsProgress
from usdsdg.workers.ray_cluster import MakePart, Resources
from usdsdg.writers.journal.earlier_files import warn_of_lost_about_all
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place_locks import shared_lock
from usdsdg.writers.parts import forget_parts, join_parts

FRAMES = "--frames"
MakeParts = Callable[[Sequence[Part], Callable[[], None]], None]


def make_dataset(places: Sequence[str], frames: int, count: int, make: MakeParts, *, unit: int = 1) -> None:
    """Make the parts of a dataset that are missing in some folder, and join them.

    places: folders and URLs to which the run writes. frames: of the dataset. count: of processes. unit: frames of an
    episode. make: makes parts, and calls its second argument again and again meanwhile.

    Raises:
        BadValue: the run writes to no folder and to no store.
        DatasetInTheWay, OutputNotWritable: as for one process.
        WorkerFailed: a process has failed.
    """
    if not places:
        raise BadValue("several processes need an output folder that all of them see; this job writes to none")
    current().run.shares_out = True
    for each in places:
        current().run.claim(each)  # removes an earlier run, or resumes it, as the options say
    claimed = current().run.folders
    current().run.release()
    make_claimed(claimed, frames, count, make, unit=unit)


def make_claimed(folders: Sequence[DatasetFolder], frames: int, count: int, make: MakeParts, *, unit: int = 1) -> None:
    """As `make_dataset`, in folders that the run has claimed and released."""
    try:
        _make_and_join(folders, frames, count, make, unit)
    finally:
        for each in folders:
            each.end_sharing()


def _make_and_join(folders: Sequence[DatasetFolder], frames: int, count: int, make: MakeParts, unit: int) -> None:
    # Where the first process of an earlier run died while it joined parts, some datasets are whole.
    places = [each.place for each in folders if not each.was_complete]
    whole = [each for each in folders if each.was_complete]
    locks = []
    try:
        for place in places:
            locks.append(shared_lock(place))
        if places:
            parts = plan(places, frames, count, unit=unit)
            progress = PartsProgress(places[0], frames)
            make(parts, progress.tick)
            progress.end()
    finally:
        for lock in locks:
            lock.release()
    for place in places:
        drop_others(place, frames)
        join_parts(place)
    for each in whole:
        warn_of_lost_about_all(each.place, each.journal.contents.shared)
        forget_parts(each.place)


def on_this_machine(
    arguments: Sequence[str], count: int, *, option: str = FRAMES, caught: list[str] | None = None
) -> MakeParts:
    """Return what makes parts with processes of this machine.

    arguments: of `usdsdg`, with the name of a command first, without those that say which frames. option: that does.
    caught: gets what the processes printed whose scripts caught an error.
    """

    def make(parts: Sequence[Part], tick: Callable[[], None]) -> None:
        start = [sys.executable, "-m", "usdsdg"]
        said = local.make_parts(lambda part: [*start, *_of_part(arguments, part, option)], parts, count, tick)
        if caught is not None:
            caught.extend(said)

    return make


def on_ray(
    arguments: Sequence[str], count: int | None, make_part: MakePart, *, address: str, resources: Resources
) -> MakeParts:
    """Return what makes parts with actors of a cluster, of which every node sees the output folder or store.

    arguments: of `usdsdg`, as in `on_this_machine`. count: None: as many actors as there is room for.
    """

    def make(parts: Sequence[Part], tick: Callable[[], None]) -> None:
        ray_cluster.make_parts(
            lambda part: _of_part(arguments, part, FRAMES), parts, count, tick, make_part,
            address=address, resources=resources,
        )  # fmt: skip

    return make


def _of_part(arguments: Sequence[str], part: Part, option: str) -> list[str]:
    """Return the arguments for a part: options come before those that belong to a script."""
    command, *rest = arguments
    return [command, option, part.frames, "--resume", "--quiet", *rest]
