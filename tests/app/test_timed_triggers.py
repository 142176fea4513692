"""`trigger.on_time` and `on_time_end`: when they fire, capture on play, and physics resets."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.app.frame_loop import get_orchestrator
from usdsdg.errors import GraphError
from usdsdg.functional import create, physics
from usdsdg.graph import evaluate
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import DEFAULT_END_TIME, get_timeline
from usdsdg.trigger import trigger_of

pytestmark = pytest.mark.usefixtures("stage")

FRAME = 1 / 60


def size_drawn(under):
    """Add a cube whose size counts the firings of a trigger; return a function that reads the size."""
    path = str(current_stage().DefinePrim("/World/cube", "Cube").GetPath())
    with under:
        rep.modify.attribute("size", rep.distribution.sequence([float(i) for i in range(1, 50)]), input_prims=path)
    return lambda: current_stage().GetPrimAtPath(path).GetAttribute("size").Get()


def times_of_firing(item, times):
    """Return the times [s] of the timeline at which a trigger is due."""
    trigger = item._trigger
    return [time for time in times if trigger.due(evaluate.TriggerContext(0, time, frozenset()))]


def test_it_fires_at_the_first_frame_that_reaches_the_interval():
    times = np.cumsum([0.4] * 12).tolist()
    fired = times_of_firing(rep.trigger.on_time(interval=1.0), times)
    # Each interval counts from the frame that fired.
    assert fired == pytest.approx([1.2, 2.4, 3.6, 4.8])


@pytest.mark.parametrize("interval", [0.1, 0.5, 1.0, 1.5])
def test_a_sum_of_frames_does_not_fire_one_frame_late(interval):
    times, time = [], 0.0
    for _ in range(600):
        time += FRAME
        times.append(time)
    fired = times_of_firing(rep.trigger.on_time(interval=interval), times)
    assert np.round(np.array(fired) / FRAME) == pytest.approx(np.arange(1, len(fired) + 1) * interval * 60)


def test_on_time_end_fires_one_frame_before():
    times = [i * FRAME for i in range(1, 200)]
    fired = times_of_firing(rep.trigger.on_time_end(interval=1.0), times)
    assert fired == pytest.approx([1.0 - FRAME, 2.0 - FRAME, 3.0 - FRAME])
    # An interval shorter than a frame fires at every frame, from the first on.
    assert times_of_firing(rep.trigger.on_time_end(interval=FRAME / 2), [0.0, FRAME, 2 * FRAME]) == [
        0,
        FRAME,
        2 * FRAME,
    ]


def test_loops_of_the_timeline_do_not_reset_the_elapsed_time():
    get_settings().set("/app/player/playSimulations", False)
    try:
        # With capture on play the timeline is stopped at the end.
        rep.orchestrator.set_capture_on_play(False)
        item = rep.trigger.on_time(interval=2 * DEFAULT_END_TIME, max_execs=1, enable_capture_on_play=False)
        size_drawn(item)
        rep.orchestrator.run(start_timeline=True)
    finally:
        get_settings().set("/app/player/playSimulations", True)
    assert get_timeline().get_elapsed_time() == pytest.approx(2 * DEFAULT_END_TIME, abs=2 * FRAME)
    assert get_timeline().get_current_time() < DEFAULT_END_TIME
    assert item.executions == 1


def test_elapsed_time_equals_the_time_after_a_stop_or_a_jump():
    timeline = get_timeline()
    timeline.play()
    for _ in range(7):
        timeline.advance(0.5)
    assert timeline.get_elapsed_time() == pytest.approx(3.5)
    assert timeline.get_current_time() == pytest.approx(3.5 - 2 * DEFAULT_END_TIME)
    timeline.set_current_time(0.25)
    assert timeline.get_elapsed_time() == 0.25
    timeline.advance(2.0)
    timeline.stop()
    assert timeline.get_elapsed_time() == timeline.get_current_time() == 0.0


def test_a_stop_restarts_the_first_interval():
    item = rep.trigger.on_time(interval=1.0)
    assert times_of_firing(item, [0.5, 1.0, 1.5, 0.0, 0.5, 1.0, 1.5]) == [1.0, 1.0]


def test_the_preview_draws_once_without_counting():
    size = size_drawn(item := rep.trigger.on_time(interval=1.0, max_execs=2))
    rep.orchestrator.preview()
    assert (size(), item.executions) == (1.0, 0)
    end = rep.trigger.on_time_end(interval=1.0)
    rep.orchestrator.preview()
    assert (size(), item.executions, end.executions) == (2.0, 0, 0)


def test_a_run_fires_max_execs_times_after_the_preview(stage):
    get_settings().set("/app/player/playSimulations", False)
    try:
        size = size_drawn(item := rep.trigger.on_time(interval=0.5, max_execs=3))
        sizes = []
        end = get_orchestrator().on_captured(lambda: sizes.append(size()))
        rep.orchestrator.run(start_timeline=True)
        end()
    finally:
        get_settings().set("/app/player/playSimulations", True)
    assert item.executions == 3
    # Each interval has as many frames as fit into it, and the third firing ended the run before another one began.
    assert sizes == [1.0] * 30 + [2.0] * 30 + [3.0] * 30
    assert size() == 4.0


def test_a_writer_that_waits_for_the_last_firing_gets_its_picture():
    class Counter(rep.Writer):
        def __init__(self):
            self.annotators, self.written = ["distance_to_camera"], 0

        def write(self, data):
            self.written += 1

    product = rep.create.render_product(rep.create.camera(), (8, 8))
    writers = Counter(), Counter()
    writers[0].attach(product, trigger=rep.trigger.on_time(interval=0.1, max_execs=3))
    rep.orchestrator.run_until_complete()
    writers[1].attach(product)
    assert [writer.written for writer in writers] == [3, 0]


@pytest.mark.parametrize(("make", "shown"), [(rep.trigger.on_time, [30]), (rep.trigger.on_time_end, [29, 59])])
def test_it_fires_for_the_pictures_that_show_its_time(make, shown):
    seen, size = [], size_drawn(make(interval=0.5, max_execs=2))
    end = get_orchestrator().on_captured(
        lambda: seen.append((round(get_timeline().get_current_time() / FRAME), size()))
    )
    rep.orchestrator.run(start_timeline=True)
    end()
    assert [frame for (frame, value), (_, before) in zip(seen[1:], seen) if value != before] == shown
    assert [frame for frame, _ in seen] == list(range(60))


@pytest.mark.parametrize(("resets", "frames"), [(False, (14, 29, 44, 59)), (True, (14, 29, 14, 29))])
def test_bodies_have_fallen_for_as_many_frames_as_the_picture_of_on_time_end_shows(stage, resets, frames):
    cube, seen, size = falling(stage), [], size_drawn(rep.trigger.on_time_end(interval=0.25, max_execs=4))
    if resets:
        rep.trigger.on_time(interval=0.5, max_execs=2)
    end = get_orchestrator().on_captured(lambda: seen.append((height(cube), size())))
    rep.orchestrator.run(start_timeline=True)
    end()
    fallen = [10 - z for (z, value), (_, before) in zip(seen[1:], seen) if value != before]
    # In steps of a frame g dt^2 n (n + 1) / 2 after n of them; 14 and 29 are the last before 0.25 and 0.5 s. These are
    # the distances in Replicator's own test of a writer that waits for on_time_end.
    assert fallen == pytest.approx([9.81 * FRAME**2 * n * (n + 1) / 2 for n in frames], rel=1e-3)


@pytest.mark.parametrize("make", [rep.trigger.on_time, rep.trigger.on_time_end])
def test_creating_the_trigger_turns_capture_on_play_on(make):
    rep.orchestrator.set_capture_on_play(False)
    make(enable_capture_on_play=False)
    assert get_settings().get_as_bool("/omni/replicator/captureOnPlay") is False
    make()
    assert get_settings().get_as_bool("/omni/replicator/captureOnPlay") is True


def test_an_interval_must_be_positive():
    with pytest.raises(GraphError, match="on_time: interval=0 must be above 0"):
        rep.trigger.on_time(interval=0)
    with pytest.raises(GraphError, match="on_time_end: interval=-1 must be above 0"):
        rep.trigger.on_time_end(interval=-1)


def height(prim: Usd.Prim) -> float:
    return UsdGeom.XformCache().GetLocalToWorldTransform(prim).ExtractTranslation()[2]


def falling(stage: Usd.Stage):
    UsdGeom.SetStageUpAxis(stage, "Z")
    cube = create.cube(position=(0, 0, 10))
    physics.create_physics_scene()
    physics.apply_rigid_body(cube)
    return cube


def played(cube: Usd.Prim, frames: int) -> list[float]:
    get_timeline().play()
    heights = []
    for _ in range(frames):
        get_app().update()
        heights.append(height(cube))
    return heights


def test_physics_is_reset_at_each_firing(stage):
    cube = falling(stage)
    with rep.trigger.on_time(interval=0.2, enable_capture_on_play=False):
        rep.modify.attribute("size", 1.0, attribute_type="double", input_prims="/Cube")
    heights = played(cube, 40)
    first = heights[:11]
    # The twelfth update reaches 0.2 s: the cube is where it was at the start, and the motion from there on repeats.
    assert first == sorted(first, reverse=True)
    assert heights[11:23] == [10.0, *first]
    assert heights[23:35] == [10.0, *first]


def test_draws_of_the_trigger_are_written_after_the_reset(stage):
    cube = falling(stage)
    with rep.trigger.on_time(interval=0.2, enable_capture_on_play=False):
        rep.modify.pose(position=rep.distribution.sequence([(0, 0, 20), (0, 0, 30)]), input_prims="/Cube")
    heights = played(cube, 30)
    falls = np.array(heights[:11]) - 10
    assert np.array(heights[12:23]) - 20 == pytest.approx(falls, abs=1e-4)
    assert [heights[11], heights[23]] == [20.0, 30.0]


def test_without_reset_physics_bodies_keep_falling(stage):
    cube = falling(stage)
    item = rep.trigger.on_time(interval=0.2, enable_capture_on_play=False, reset_physics=False)
    heights = played(cube, 30)
    assert item.executions == 2
    assert heights == sorted(heights, reverse=True)


def test_a_loaded_trigger_resets_physics_as_the_original():
    made = [rep.trigger.on_time(), rep.trigger.on_time(reset_physics=False), rep.trigger.on_time_end()]
    again = [trigger_of(item.node) for item in made]
    assert [trigger.prepare is None for trigger in again] == [False, True, True]
    assert not again[2].due(evaluate.TriggerContext(-1, 0.0, frozenset(), preview=True))
    assert again[2].due(evaluate.TriggerContext(0, 1.0 - FRAME, frozenset()))
