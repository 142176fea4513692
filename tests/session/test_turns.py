"""Calls of several threads and tasks take turns: each has its own frame, and a run can be stopped from outside."""

import asyncio
import itertools
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import usdsdg as rep
from usdsdg.app.status import OrchestratorError, Status
from usdsdg.errors import UsdsdgWarning
from usdsdg.session import turns as turns_module
from usdsdg.session.stage_context import current_stage, new_stage
from usdsdg.session.turns import Turns

THREADS = 4
SECONDS = 100  # that a thread may take on a busy machine


@pytest.fixture
def depth():
    """The annotator of a camera in front of a cube that is nearer in each frame."""
    new_stage()
    with rep.trigger.on_frame(), rep.create.cube():
        rep.modify.pose(position=rep.distribution.sequence([(float(x), 0, 0) for x in range(8)]))
    camera = rep.create.camera(position=(20, 0, 0), look_at=(0, 0, 0))
    found = rep.annotators.get("distance_to_image_plane")
    found.attach(rep.create.render_product(camera, (9, 9)))
    return found


def nearest(annotator) -> float:
    return round(float(np.min(annotator.get_data())), 3)


def wait_for(condition) -> None:
    """Wait until another thread has done something."""
    done = threading.Event()
    for _ in range(SECONDS * 100):
        if condition():
            return
        done.wait(0.01)
    raise AssertionError("it did not come")


def test_tasks_that_capture_at_once_have_the_data_of_their_own_frames(depth):
    async def task() -> list[float]:
        seen = []
        for _ in range(2):
            await rep.orchestrator.step_async()
            seen.append(nearest(depth))
        return seen

    async def tasks() -> list[list[float]]:
        return await asyncio.gather(*(task() for _ in range(3)))

    # The cube has edges of 1 m.
    assert sorted(itertools.chain(*asyncio.run(tasks()))) == [14.5, 15.5, 16.5, 17.5, 18.5, 19.5]


def test_a_step_beside_a_run_has_its_own_frame_too(depth):
    async def both() -> list[float]:
        run = asyncio.ensure_future(rep.orchestrator.run_async(num_frames=6))
        seen = []
        for _ in range(3):
            before = rep.orchestrator.get_orchestrator().captures
            await rep.orchestrator.step_async()
            captures = rep.orchestrator.get_orchestrator().captures
            seen.append(nearest(depth) == 19.5 - (captures - 1) and captures > before)
        await run
        return seen

    assert asyncio.run(both()) == [True] * 3


def test_steps_are_awaited_in_one_loop_after_another(depth):
    async def pair() -> None:
        await asyncio.gather(rep.orchestrator.step_async(), rep.orchestrator.step_async())

    asyncio.run(pair())
    asyncio.run(pair())
    assert nearest(depth) == 16.5


def test_a_canceled_step_leaves_the_turn_to_the_next(depth):
    async def canceled() -> None:
        step = asyncio.ensure_future(rep.orchestrator.step_async())
        await asyncio.sleep(0)
        step.cancel()
        with pytest.raises(asyncio.CancelledError):
            await step
        await asyncio.wait_for(rep.orchestrator.step_async(), SECONDS)

    asyncio.run(canceled())


def test_a_second_run_beside_the_first_is_an_error(depth):
    async def both() -> list:
        runs = (rep.orchestrator.run_async(num_frames=2) for _ in range(2))
        return await asyncio.gather(*runs, return_exceptions=True)

    first, second = asyncio.run(both())
    assert first is None
    assert isinstance(second, OrchestratorError)
    assert "await it" in str(second)
    rep.orchestrator.run(num_frames=1)


def test_a_run_that_was_stopped_while_it_waited_does_not_go_on_with_the_next(depth):
    async def two() -> int:
        first = asyncio.ensure_future(rep.orchestrator.run_async(num_frames=7))
        await asyncio.sleep(0)
        rep.orchestrator.stop()
        await rep.orchestrator.run_async(num_frames=2)
        await first
        return rep.orchestrator.get_orchestrator().captures

    assert asyncio.run(two()) == 2


def test_threads_that_capture_at_once_make_one_frame_each(depth):
    def step(_: int) -> float:
        rep.orchestrator.step()
        return nearest(depth)

    with ThreadPoolExecutor(THREADS) as pool:
        seen = list(pool.map(step, range(8)))
    assert rep.orchestrator.get_orchestrator().captures == 8
    assert nearest(depth) == min(seen) == 12.5


def test_threads_that_author_at_once_make_all_prims_and_each_its_own_blocks():
    new_stage()
    inside, authored = threading.Event(), threading.Event()

    def author(_: int) -> None:
        for _ in range(10):
            rep.create.cube()

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(author, range(THREADS)))
    cubes = [prim for prim in current_stage().Traverse() if prim.GetTypeName() in ("Cube", "Mesh")]
    assert len(cubes) == 10 * THREADS

    def other() -> None:
        inside.wait(SECONDS)
        rep.create.sphere()
        authored.set()

    thread = threading.Thread(target=other)
    thread.start()
    with rep.trigger.on_frame() as trigger:
        inside.set()
        assert authored.wait(SECONDS)
    thread.join(SECONDS)
    assert not trigger.trigger.nodes  # the sphere was created at once


def test_another_thread_pauses_resumes_and_stops_a_run(depth):
    errors: list[BaseException] = []

    def run() -> None:
        try:
            rep.orchestrator.run(num_frames=1_000_000)
        except BaseException as error:  # noqa: BLE001 - told by the test
            errors.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    orchestrator = rep.orchestrator.get_orchestrator()
    for _ in range(3):
        before = orchestrator.captures
        wait_for(lambda before=before: orchestrator.captures > before)
        rep.orchestrator.pause()
        assert rep.orchestrator.get_status() is Status.PAUSED
        captured = orchestrator.captures
        assert depth.get_data().shape == (9, 9)
        assert orchestrator.captures == captured
        rep.orchestrator.resume()
    rep.orchestrator.stop()
    thread.join(SECONDS)
    assert not errors
    assert not thread.is_alive()
    assert rep.orchestrator.get_status() is Status.STOPPED


def test_a_thread_that_waits_for_long_says_for_whom(monkeypatch):
    monkeypatch.setattr(turns_module, "PATIENCE", 0.01)
    turns, told, may_end = Turns(), threading.Event(), threading.Event()

    def hold() -> None:
        with turns:
            told.set()
            may_end.wait(SECONDS)

    thread = threading.Thread(target=hold, name="capturing")
    thread.start()
    told.wait(SECONDS)
    threading.Timer(0.5, may_end.set).start()
    with pytest.warns(UsdsdgWarning, match="'MainThread' has waited .* 'capturing'"), turns:
        pass
    thread.join(SECONDS)


def test_what_a_frame_waits_for_does_not_wait_for_the_frame():
    turns, done = Turns(), []

    def job() -> None:
        turns.exempt_thread()
        with turns:
            done.append(True)

    with turns:
        thread = threading.Thread(target=job)
        thread.start()
        thread.join(SECONDS)
    assert done


def test_a_frame_that_waits_for_another_thread_lets_it_call():
    turns, wanted, done = Turns(), threading.Event(), threading.Event()

    def other() -> None:
        wanted.wait(SECONDS)
        with turns:
            done.set()

    thread = threading.Thread(target=other)
    thread.start()
    with turns, turns:
        wanted.set()
        assert not done.wait(0.1)
        with turns.set_aside():
            assert done.wait(SECONDS)
        assert turns._depth == 2
    thread.join(SECONDS)
    with turns.set_aside():  # of a thread that has no turn
        assert turns._depth == 0


def test_who_was_interrupted_while_it_waited_to_have_the_turn_back_leaves_it_to_the_other(monkeypatch):
    monkeypatch.setattr(turns_module, "PATIENCE", 0.01)
    turns, has_it, may_end = Turns(), threading.Event(), threading.Event()

    def interrupt() -> None:
        raise KeyboardInterrupt

    def other() -> None:
        with turns:
            has_it.set()
            may_end.wait(SECONDS)

    monkeypatch.setattr(turns, "_tell", interrupt)
    thread = threading.Thread(target=other)

    def give_away() -> None:
        with turns, turns, turns.set_aside():
            thread.start()
            assert has_it.wait(SECONDS)

    with pytest.raises(KeyboardInterrupt):
        give_away()
    assert turns._depth == 1
    may_end.set()
    thread.join(SECONDS)
    with turns:
        assert turns._depth == 1


class _Interrupts:
    """Raises KeyboardInterrupt at one of the steps of the interpreter in functions of `usdsdg.session.turns`."""

    def __init__(self, at: int) -> None:
        self.left = at

    def __call__(self, frame, event, arg):
        if frame.f_code.co_filename != turns_module.__file__:
            return None
        frame.f_trace_opcodes = True
        return self.step

    def step(self, frame, event, arg):
        if event == "opcode":
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt
        return self.step


def test_an_interrupt_at_any_step_gives_the_turn_back():
    @turns_module.in_turn
    def inner() -> None:
        with turns_module.turns.set_aside():
            pass

    @turns_module.in_turn
    def outer() -> None:
        inner()

    def is_free() -> bool:
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(turns_module.turns._lock.acquire, timeout=0.001).result()

    steps = 0
    for at in itertools.count(1):
        interrupts, before = _Interrupts(at), sys.gettrace()
        sys._getframe().f_trace_opcodes = True  # without which Python 3.12 traces no steps of other frames
        sys.settrace(interrupts)
        try:
            outer()
        except KeyboardInterrupt:
            steps += 1
        finally:
            sys.settrace(before)
        assert is_free(), at
        turns_module.turns._lock = threading.RLock()  # which that thread has ended with
        assert turns_module.turns.depth == 0, at
        if interrupts.left > 0:
            break
    assert steps > 100


def test_the_turn_is_waited_for_only_so_long():
    turns, has_it, may_end = Turns(), threading.Event(), threading.Event()

    def other() -> None:
        with turns:
            has_it.set()
            may_end.wait(SECONDS)

    thread = threading.Thread(target=other)
    thread.start()
    assert has_it.wait(SECONDS)
    with turns.within(0.01):
        assert turns.depth == 0
    may_end.set()
    thread.join(SECONDS)
    with turns.within(0.01), turns.within(0.01):
        assert turns.depth == 2
    assert turns.depth == 0


def test_locks_of_loops_that_are_closed_are_dropped():
    async def wait_for_turn() -> None:
        async def one() -> None:
            async with turns_module.turn_of_task():
                await asyncio.sleep(0)

        await asyncio.gather(one(), one())  # of which one waits, so that the lock refers to the loop

    for _ in range(5):
        asyncio.run(wait_for_turn())
    assert sum(loop.is_closed() for loop in turns_module._of_loops) <= 1


FORK = """
    import multiprocessing, threading, time
    import usdsdg as rep
    from usdsdg.session.turns import turns

    def child():
        rep.create.cube()

    def hold():
        with turns:
            held.set()
            time.sleep(3)

    held = threading.Event()
    threading.Thread(target=hold, daemon=True).start()
    held.wait()
    process = multiprocessing.get_context("fork").Process(target=child)
    process.start()
    process.join(60)
    print(process.exitcode)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork here")
def test_a_forked_process_has_its_turns_whoever_had_them():
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", textwrap.dedent(FORK)], capture_output=True, text=True, timeout=120
    )
    assert done.stdout.strip() == "0", done.stderr


FORK_IN_TURN = """
    import os, threading
    from usdsdg.session.turns import turns

    def other():
        with turns:
            entered.append(True)

    entered = []
    with turns, turns:
        child = os.fork()
        if not child:
            thread = threading.Thread(target=other)
            thread.start()
            thread.join(0.2)
            assert not entered
    if not child:
        thread.join(60)
        os._exit(0 if entered else 1)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork here")
def test_a_process_forked_within_a_call_has_the_turn_until_the_call_ends():
    program = textwrap.dedent(FORK_IN_TURN)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "0", done.stderr
