"""Nature as the oracle: one stage with the experiments of a first physics course, run for ten seconds.

Tolerances: positions of a symplectic Euler integration are off by v·dt/2 after a fall (dt = 1/60 s); contacts
within a millimeter at rest; slides 3 %, rebounds 5 %, the mean height of a pile 10 %.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pxr import UsdPhysics

from tests.physics.scenes import add, new_stage, physics_material, playing, position
from tests.sampled_cases import crossed

G = 9.81


class Experiments:
    """Paths recorded over all steps: positions[name] is (steps, 3)."""

    def __init__(self) -> None:
        stage = new_stage()
        standard = physics_material(stage, "/World/standard")
        bouncy = physics_material(stage, "/World/bouncy", restitution=0.5)
        self.prims = {}

        def body(name, kind="Cube", **options):
            self.prims[name] = add(stage, f"/World/{name}", kind, **{"material": standard, **options})

        def fixed(name, **options):
            add(stage, f"/World/{name}", body=False, **{"material": standard, **options})

        fixed("ground", at=(0, 0, -0.5), scale=(30, 30, 0.5))
        fixed("bouncy_ground", at=(0, 20, 0), scale=(2, 2, 0.5), material=bouncy)
        body("fall", "Sphere", at=(-20, -20, 60))
        body("rest", at=(0, 0, 0.25), scale=(0.2, 0.2, 0.2))
        body("bounce", "Sphere", at=(0, 20, 1.6), material=bouncy)
        for name, degrees, y in (("stick", 20.0, -10.0), ("slide", 35.0, -14.0)):
            fixed(f"ramp_{name}", at=(0, y, 1), rotate=(0, degrees, 0), scale=(3, 1, 0.1))
            a = math.radians(degrees)
            normal, down = np.array([math.sin(a), 0, math.cos(a)]), np.array([math.cos(a), 0, -math.sin(a)])
            at = np.array([0, y, 1]) + 0.2 * normal - 1.5 * down
            body(name, at=tuple(at), rotate=(0, degrees, 0))
        for i in range(5):
            body(f"stack_{i}", at=(5, 0, 0.2 + 0.401 * i), scale=(0.2, 0.2, 0.2))
        self._fill_bin(fixed, body)
        self.run(stage)

    @staticmethod
    def _fill_bin(fixed, body) -> None:
        for name, at, scale in (
            ("east", (10.6, 0, 1), (0.1, 0.7, 1)),
            ("west", (9.4, 0, 1), (0.1, 0.7, 1)),
            ("north", (10, 0.6, 1), (0.5, 0.1, 1)),
            ("south", (10, -0.6, 1), (0.5, 0.1, 1)),
        ):
            fixed(f"bin_{name}", at=at, scale=scale)
        rng = np.random.default_rng(3)
        for i in range(60):
            x, y = rng.uniform(-0.35, 0.35, 2)
            at = (10 + x, y, 0.15 + 0.06 * i)
            if i % 2:
                body(f"pile_{i}", "Sphere", at=at, scale=(0.08, 0.08, 0.08))
            else:
                body(f"pile_{i}", at=at, rotate=tuple(rng.uniform(0, 360, 3)), scale=(0.08, 0.06, 0.07))

    def run(self, stage) -> None:
        engine = playing(stage)
        frames = []
        engine.subscribe_step(lambda dt: frames.append([position(prim) for prim in self.prims.values()]))
        assert engine.advance(10.0) == 600
        self.positions = dict(zip(self.prims, np.array(frames).swapaxes(0, 1)))


@pytest.fixture(scope="module")
def experiments() -> Experiments:
    return Experiments()


def test_free_fall(experiments):
    """As in PhysX, a body falls g dt² n(n+1)/2 in n steps: 0.08 m too far in one second."""
    fallen = 60 - experiments.positions["fall"][:60, 2]
    n = np.arange(1, 61)
    np.testing.assert_allclose(fallen, G / 3600 * n * (n + 1) / 2, atol=1e-3)


def test_box_rests_at_its_half_height(experiments):
    assert experiments.positions["rest"][-1, 2] == pytest.approx(0.2, abs=1e-3)


def test_rebound_height(experiments):
    """A drop of 1 m with restitution 0.5 rebounds to 0.25 m."""
    height = experiments.positions["bounce"][:, 2]
    lowest = int(height[:45].argmin())
    assert height[:60].min() == pytest.approx(0.6, abs=0.02)
    assert height[lowest : lowest + 50].max() == pytest.approx(0.85, rel=0.05)


def test_friction_holds_below_its_angle(experiments):
    """tan 20° = 0.36 < 0.5."""
    path = experiments.positions["stick"]
    assert np.linalg.norm(path[179] - path[0]) < 2e-3


def test_slide_above_the_friction_angle(experiments):
    """a = g (sin 35° - 0.5 cos 35°); the first recorded position is one step after the start."""
    path = experiments.positions["slide"]
    acceleration = G * (math.sin(math.radians(35)) - 0.5 * math.cos(math.radians(35)))
    assert np.linalg.norm(path[59] - path[0]) == pytest.approx(acceleration / 2, rel=0.03)


def test_stack_stands(experiments):
    top = experiments.positions["stack_4"][-1]
    assert top[2] == pytest.approx(1.8, abs=5e-3)
    drift = max(np.abs(experiments.positions[f"stack_{i}"][-1, :2] - (5, 0)).max() for i in range(5))
    assert drift < 0.01


def test_pile_stays_in_its_bin(experiments):
    """PhysX piles the same bodies to a mean height of 0.156 m (0.160 with four times finer steps)."""
    last = np.array([path[-1] for name, path in experiments.positions.items() if name.startswith("pile")])
    inside = (np.abs(last[:, :2] - (10, 0)) < 0.5).all(axis=1) & (last[:, 2] > 0.0)
    assert inside.all()
    assert last[:, 2].mean() == pytest.approx(0.158, rel=0.1)


def test_bodies_at_rest_do_not_creep(experiments):
    """Over the last second, boxes that lie still move by less than a hundredth of a millimeter."""
    for name in ("rest", "stick", "stack_0", "stack_4"):
        path = experiments.positions[name]
        assert np.linalg.norm(path[-1] - path[-61]) < 1e-5, name


@pytest.mark.parametrize(("rate", "meters_per_unit"), crossed([60, 30, 120, 320], [1.0, 0.01]))
def test_free_fall_is_that_of_physx_at_every_rate(rate, meters_per_unit):
    """g dt² n(n+1)/2 within a millimeter, whatever the number of substeps; also for a body that is thrown up."""
    stage = new_stage(meters_per_unit=meters_per_unit)
    stage.GetPrimAtPath("/PhysicsScene").GetAttribute("physxScene:timeStepsPerSecond").Set(rate)
    meter = 1 / meters_per_unit
    ball = add(stage, "/World/ball", "Sphere", at=(0, 0, 20 * meter), scale=(0.1 * meter,) * 3)
    thrown = add(stage, "/World/thrown", at=(5 * meter, 0, 20 * meter), scale=(0.1 * meter,) * 3)
    UsdPhysics.RigidBodyAPI(thrown).CreateVelocityAttr((meter, 0, 3 * meter))
    weightless = add(stage, "/World/weightless", at=(-5 * meter, 0, 20 * meter), gravity=False)
    engine = playing(stage)
    found = []
    engine.subscribe_step(lambda dt: found.append([position(prim) / meter for prim in (ball, thrown, weightless)]))
    engine.advance(1.0)
    t, n = np.arange(1, rate + 1) / rate, np.arange(1, rate + 1)
    fallen = G / rate**2 * n * (n + 1) / 2
    still = np.zeros(rate)
    expected = [(still, still, 20 - fallen), (5 + t, still, 20 + 3 * t - fallen), (still - 5, still, still + 20)]
    np.testing.assert_allclose(np.array(found).transpose(1, 2, 0), expected, atol=1e-3)


@pytest.mark.parametrize(
    ("seconds", "steps"),
    [(0.0333333, 2), (0.033333, 2), (0.0333, 2), (1 / 30, 2), (0.01667, 1), (0.016667, 1), (0.0166666, 1)],
)
def test_time_that_is_nearly_whole_steps_takes_them_at_once(seconds, steps):
    engine = playing(new_stage())
    assert [engine.advance(seconds) for _ in range(100)] == [steps] * 100


def test_time_that_is_no_whole_step_is_carried_over():
    engine = playing(new_stage())
    assert [engine.advance(1 / 120) for _ in range(4)] == [0, 1, 0, 1]
    assert [engine.advance(0.025) for _ in range(4)] == [1, 2, 1, 2]
