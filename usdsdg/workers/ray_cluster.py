"""Actors of Ray that make the parts of a dataset, on this machine or on a cluster."""

from __future__ import annotations

import importlib
import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from usdsdg.errors import Unsupported, WorkerFailed
from usdsdg.workers.local import ATTEMPTS, POLL_SECONDS, TAIL
from usdsdg.workers.plan import Part

# Of `--ray` without an address: a cluster of this machine alone, which ends with the command.
LOCAL = "local"
ROOM_SECONDS = 600.0  # which a cluster may take to start nodes
# Runs in an actor: gets the arguments of `usdsdg`, returns the exit code and what was printed.
MakePart = Callable[[Sequence[str]], tuple[int, str]]


@dataclass(frozen=True)
class Resources:
    """What one actor takes of a node."""

    cpus: float
    gpus: float


@dataclass
class _Work:
    part: Part
    attempt: int
    actor: Any


def make_parts(
    command: Callable[[Part], Sequence[str]],
    parts: Sequence[Part],
    count: int | None,
    tick: Callable[[], None],
    make_part: MakePart,
    *,
    address: str,
    resources: Resources,
) -> None:
    """Make parts with actors, `count` at a time; where one dies, another resumes its part.

    command: the arguments of `usdsdg` that make a part, for make_part, which nodes import by its name.
    count: None: as many as the cluster has room for. tick: called again and again meanwhile.
    address: of a cluster, "auto" for the one of this machine, or LOCAL.

    Raises:
        Unsupported: Ray is not installed.
        WorkerFailed: there is no such cluster or no room in it, an actor ended with an error, or several died at one
            part.
    """
    with _cluster(address, cpus=count and count * resources.cpus) as ray:
        room = _room(ray, resources)
        if room < 1:
            raise WorkerFailed(f"the cluster has no node with {resources.cpus:g} CPUs and {resources.gpus:g} GPUs")
        actor = ray.remote(num_cpus=resources.cpus, num_gpus=resources.gpus, max_restarts=0)(_Maker)
        work = deque((part, 1) for part in parts)
        _run(ray, lambda: actor.remote(make_part), command, work, min(count or room, room, len(parts)), tick)


def _run(
    ray: Any,
    new: Callable[[], Any],
    command: Callable[[Part], Sequence[str]],
    waiting: deque[tuple[Part, int]],
    count: int,
    tick: Callable[[], None],
) -> None:
    """Let `count` actors make what is waiting; new: starts an actor.

    A part goes to an actor that runs. One in place of an actor that has died may wait for room for long, as after the
    loss of a node; the others then make its part.
    """
    starting: dict[Any, Any] = {}  # actors by what they answer once they run
    idle: list[Any] = []
    running: dict[Any, _Work] = {}
    busy_at = time.monotonic()
    try:
        while waiting or running:
            for _ in range(min(count - len(idle) - len(running), len(waiting)) - len(starting)):
                actor = new()
                starting[actor.is_ready.remote()] = actor
            while waiting and idle:
                (part, attempt), actor = waiting.popleft(), idle.pop()
                running[actor.make.remote(list(command(part)))] = _Work(part, attempt, actor)
            done, _ = ray.wait([*starting, *running], timeout=POLL_SECONDS)
            tick()
            for reference in done:
                if reference in starting:
                    actor = starting.pop(reference)
                    if _has_started(ray, reference):
                        idle.append(actor)
                    continue
                work = running.pop(reference)
                if _succeeded(ray, reference, work):
                    idle.append(work.actor)
                else:
                    waiting.appendleft((work.part, work.attempt + 1))
            busy_at = time.monotonic() if running or idle else busy_at
            if time.monotonic() - busy_at > ROOM_SECONDS:
                raise WorkerFailed(
                    f"the cluster has had no room for an actor for {ROOM_SECONDS:g} s; resume with --resume"
                )
    finally:
        for actor in [*starting.values(), *idle, *(work.actor for work in running.values())]:
            ray.kill(actor)


def _has_started(ray: Any, reference: Any) -> bool:
    """Return whether an actor runs; False if it has died before it answered."""
    try:
        return ray.get(reference)
    except ray.exceptions.RayActorError:
        return False


def _succeeded(ray: Any, reference: Any, work: _Work) -> bool:
    """Return whether a part was made; False if its actor has died and another should go on."""
    try:
        code, printed = ray.get(reference)
    except ray.exceptions.RayActorError as error:
        if work.attempt == ATTEMPTS:
            raise WorkerFailed(f"{ATTEMPTS} actors died at the frames {work.part.frames}: {error}") from error
        return False
    except ray.exceptions.RayTaskError as error:
        raise WorkerFailed(f"the actor of the frames {work.part.frames} failed: {error}") from error
    if code:
        raise WorkerFailed(
            f"the actor of the frames {work.part.frames} ended with exit code {code}:\n{printed[-TAIL:].strip()}"
        )
    return True


class _Maker:
    """Makes one part after the other."""

    def __init__(self, make_part: MakePart) -> None:
        self._make_part = make_part

    def is_ready(self) -> bool:
        """Return True, as soon as the actor runs."""
        return True

    def make(self, arguments: list[str]) -> tuple[int, str]:
        """Return the exit code of a command, and what it printed."""
        return self._make_part(arguments)


def _room(ray: Any, resources: Resources) -> int:
    """Return how many actors the nodes have room for."""
    rooms = []
    for node in ray.nodes():
        if node["Alive"]:
            has = node["Resources"]
            fits = [
                has.get(name, 0.0) / want for name, want in (("CPU", resources.cpus), ("GPU", resources.gpus)) if want
            ]
            rooms.append(int(min(fits, default=1)))
    return sum(rooms)


def check_installed() -> None:
    """Check that Ray is there.

    Raises:
        Unsupported: it is not, or cannot be imported.
    """
    try:
        importlib.import_module("ray")
    except ImportError as error:
        raise Unsupported(f"--ray needs Ray: pip install 'usdsdg[ray]' ({error})") from error


@contextmanager
def _cluster(address: str, *, cpus: float | None) -> Iterator[Any]:
    """Connect to a cluster, and leave it afterward.

    cpus: that a cluster of this machine alone has for actors; None: as many as the machine.
    """
    check_installed()
    import ray  # type: ignore[import-not-found]

    # In a job of `ray job submit`, and below a process that has joined a cluster, the environment names it.
    wanted = None if address == LOCAL and os.environ.get("RAY_ADDRESS") else address
    options = {"include_dashboard": False, "num_cpus": cpus} if wanted == LOCAL else {}
    was_there = ray.is_initialized()
    try:
        if not was_there:
            ray.init(address=wanted, log_to_driver=False, logging_level="ERROR", **options)
        yield ray
    except ConnectionError as error:
        raise WorkerFailed(f"there is no cluster of Ray at {address}: {error}") from error
    finally:
        if not was_there:
            ray.shutdown()
