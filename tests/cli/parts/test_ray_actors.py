"""How parts are given to actors that start late, die, or find no room; the soak `ray` has a real cluster."""

from collections import deque
from types import SimpleNamespace

import pytest

from usdsdg.errors import WorkerFailed
from usdsdg.workers import ray_cluster
from usdsdg.workers.plan import Part

PARTS = [Part(first, first + 1) for first in range(6)]


class Died(Exception):
    """What Ray raises for an actor that has died."""


class FakeRay:
    """Actors that answer at once, apart from those that find no room or die."""

    exceptions = SimpleNamespace(RayActorError=Died, RayTaskError=KeyError)

    def __init__(self, *, without_room=(), dying=()):
        self.without_room, self.dying = set(without_room), set(dying)
        self.actors, self.made, self.killed = 0, [], []

    def new(self):
        number, self.actors = self.actors, self.actors + 1
        ready = SimpleNamespace(remote=lambda: ("ready", number, None))
        make = SimpleNamespace(remote=lambda arguments: ("make", number, arguments[0]))
        return SimpleNamespace(number=number, is_ready=ready, make=make)

    def wait(self, references, timeout):
        done = [each for each in references if each[1] not in self.without_room][:1]
        return done, [each for each in references if each not in done]

    def get(self, reference):
        kind, number, part = reference
        if kind == "make" and number in self.dying:
            self.without_room.add(number)
            raise Died
        if kind == "make":
            self.made.append(part)
            return 0, ""
        return True

    def kill(self, actor):
        self.killed.append(actor.number)


def run(ray, count=2):
    waiting = deque((part, 1) for part in PARTS)
    ray_cluster._run(ray, ray.new, lambda part: [part.frames], waiting, count, lambda: None)


def test_every_part_is_made_once_and_all_actors_are_ended():
    ray = FakeRay()
    run(ray)
    assert sorted(ray.made) == [part.frames for part in PARTS]
    assert sorted(ray.killed) == list(range(ray.actors)) == [0, 1]


def test_an_actor_without_room_gets_no_part():
    ray = FakeRay(without_room={1})
    run(ray)
    assert sorted(ray.made) == [part.frames for part in PARTS]
    assert sorted(ray.killed) == [0, 1]


def test_where_an_actor_dies_another_makes_its_part_though_the_new_one_finds_no_room():
    ray = FakeRay(dying={0}, without_room={2})
    run(ray)
    assert sorted(ray.made) == [part.frames for part in PARTS]


def test_a_cluster_without_room_is_not_waited_for_for_ever(monkeypatch):
    monkeypatch.setattr(ray_cluster, "ROOM_SECONDS", 0.05)
    with pytest.raises(WorkerFailed, match="no room for an actor"):
        run(FakeRay(without_room={0, 1}))


def test_a_part_at_which_actors_die_again_and_again_is_an_error():
    with pytest.raises(WorkerFailed, match="4 actors died at the frames 0:1"):
        run(FakeRay(dying=set(range(40))), count=1)
