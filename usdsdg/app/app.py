"""The application and its updates, with the interface of `omni.kit.app`.

The order of one update: events and pending nodes of the graph → timeline → physics → update listeners → coroutines that
await the next update → other tasks that are ready.
"""

import asyncio
import time
from collections.abc import Callable, Coroutine
from importlib import metadata
from typing import Any

from usdsdg.app.script_loop import ScriptLoop
from usdsdg.app.window_wait import WindowWait
from usdsdg.errors import Unsupported
from usdsdg.graph.evaluate import graph, puts_bodies_back
from usdsdg.listeners import Listeners
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline
from usdsdg.session.turns import in_turn


class App:
    """Updates on demand: one happens when a script calls `update` or awaits the next one."""

    def __init__(self) -> None:
        self._listeners: Listeners[[float]] = Listeners()
        self._early_listeners: Listeners[[float]] = Listeners()
        self._closing_listeners: Listeners[[]] = Listeners()
        self._waiters: list[asyncio.Future[None]] = []
        self._updates = 0
        self._started = time.perf_counter()
        self._running = True
        self._window_wait = WindowWait()
        self._frames_at_question = 0
        self._seconds_of_update: float | None = None
        self._loop: ScriptLoop | None = None

    # --- updates ---
    @in_turn
    def update(self) -> None:
        """Run one application update; a playing timeline advances by `seconds_of_update`."""
        timeline = get_timeline()
        dt = self.seconds_of_update()
        self._early_listeners.call(dt)
        with timeline.before_picture(dt if timeline.is_playing() and timeline.is_auto_updating() else 0.0):
            fired = graph().evaluate(time=timeline.get_picture_elapsed_time())
        plays = timeline.is_playing() and timeline.is_auto_updating()
        if plays:
            self.advance(dt, bodies_wait=puts_bodies_back(fired))
        self._updates += 1
        current().orchestrator.capture_on_play(plays)
        self._listeners.call(dt)
        for waiter in self._take_waiters():
            waiter.set_result(None)
        self.run_ready_tasks()

    def advance(self, seconds: float, *, bodies_wait: bool = False) -> None:
        """Advance the timeline by `seconds`, and physics if the timeline plays, unless `bodies_wait`."""
        timeline = get_timeline()
        plays = timeline.is_playing() and get_settings().get_as_bool("/app/player/playSimulations")
        simulates = plays and not bodies_wait
        timeline.advance(seconds)
        if simulates:
            engines.physics().advance(seconds, until=timeline.get_current_time())

    def seconds_of_update(self) -> float:
        """Return how far an update advances a playing timeline [s]: by default a time code."""
        if self._seconds_of_update is not None:
            return self._seconds_of_update
        return 1.0 / get_timeline().get_time_codes_per_seconds()

    def set_seconds_of_update(self, seconds: float | None) -> None:
        """Let updates advance a playing timeline by `seconds`; None: by one time code."""
        self._seconds_of_update = seconds

    async def next_update_async(self) -> float:
        """Wait for the next update, shared by all waiters; return its duration [s]."""
        loop = asyncio.get_running_loop()
        if not any(waiter.get_loop() is loop and not waiter.done() for waiter in self._waiters):
            loop.call_soon(self._update_for_waiters)
        waiter: asyncio.Future[None] = loop.create_future()
        self._waiters.append(waiter)
        await waiter
        return self.seconds_of_update()

    pre_update_async = post_update_async = next_update_async

    def _update_for_waiters(self) -> None:
        """Run the update that tasks wait for, unless one has happened in the meantime."""
        if all(waiter.done() for waiter in self._waiters):
            return
        try:
            self.update()
        except Exception as error:  # noqa: BLE001 - raised in the tasks that wait for the update
            for waiter in self._take_waiters():
                waiter.set_exception(error)

    def _take_waiters(self) -> list[asyncio.Future[None]]:
        waiters, self._waiters = self._waiters, []
        return [waiter for waiter in waiters if not waiter.done()]

    def subscribe_update(self, listener: Callable[[float], None]) -> Callable[[], None]:
        """Call `listener(dt)` after each update; return the unsubscriber."""
        return self._listeners.subscribe(listener)

    def subscribe_before_update(self, listener: Callable[[float], None]) -> Callable[[], None]:
        """Call `listener(dt)` before the triggers of each update; return the unsubscriber."""
        return self._early_listeners.subscribe(listener)

    def get_update_number(self) -> int:
        return self._updates

    def is_running(self) -> bool:
        """True until `close`, or until a script with a limit of frames only waits for its window to be closed."""
        frames, before = current().observations.frames, self._frames_at_question
        self._frames_at_question = frames
        idle = frames == before and not get_timeline().is_playing() and not self.has_other_tasks()
        ends = current().orchestrator.frames_without_end is not None
        if self._running and self._window_wait.is_over(self._updates, idle=idle, ends=ends):
            self.close()
        return self._running

    def subscribe_closing(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call `listener()` when the application is closed; return the unsubscriber."""
        return self._closing_listeners.subscribe(listener)

    # --- what Kit's application has beside updates ---
    def get_extension_manager(self) -> Any:
        """Return the manager of extensions (`omni.ext`)."""
        return current().extension_manager

    def get_update_event_stream(self) -> Any:
        """Return the stream of events (`carb.events`) with one after each update; its payload has "dt" [s]."""
        return current().event_streams.update

    get_post_update_event_stream = get_update_event_stream

    def get_pre_update_event_stream(self) -> Any:
        """Return the stream of events (`carb.events`) with one before each update; its payload has "dt" [s]."""
        return current().event_streams.pre_update

    def get_shutdown_event_stream(self) -> Any:
        """Return the stream of events (`carb.events`) with those of the end of the application, when it is closed."""
        return current().event_streams.shutdown

    def get_message_bus_event_stream(self) -> Any:
        """Return the stream of events that scripts push and listen to."""
        return current().event_streams.message_bus

    def get_time_since_start_s(self) -> float:
        """Return the wall-clock time since the application was made [s]."""
        return time.perf_counter() - self._started

    def get_time_since_start_ms(self) -> float:
        """Return the wall-clock time since the application was made [ms]."""
        return self.get_time_since_start_s() * 1000.0

    def get_app_version(self) -> str:
        """Return the version of usdsdg."""
        return metadata.version("usdsdg")

    get_build_version = get_kit_version = get_app_version

    def is_app_ready(self) -> bool:
        """Return True: nothing is loaded later."""
        return True

    def print_and_log(self, message: str) -> None:
        """Print a line."""
        print(message)

    def post_quit(self, return_code: int = 0) -> None:
        """Make `is_running` False; tasks that still run are not waited for."""
        self.close()

    # --- the event loop of scripts ---
    def run(self, script: Callable[[], Any]) -> None:
        """Call `script` with an event loop, then update until every task that it started has ended.

        The first exception of a task that is never retrieved is raised here.
        """
        loop = self.open_loop()
        try:
            script()
            loop.run_until_done(lambda: self._running)
        finally:
            self._loop = None
            loop.close()

    def run_until_complete(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Run one coroutine to its end, with updates while it awaits them, and return its result.

        Raises:
            Unsupported: an event loop runs on this thread, as in coroutines and in notebooks.
        """
        if asyncio._get_running_loop() is not None:
            work.close()
            raise Unsupported(
                f"{work.__qualname__} cannot be run to its end within an event loop, as of a coroutine or a notebook: "
                f"`await {work.__qualname__}(...)` there"
            )
        return self.open_loop().run_until_complete(work)

    def open_loop(self) -> ScriptLoop:
        """Return the event loop that `asyncio.ensure_future` uses; a new one if there is none."""
        self._running = True
        if self._loop is None:
            self._loop = ScriptLoop()
        return self._loop

    def run_ready_tasks(self) -> None:
        """Run each task of the script that is ready for one step."""
        if self._loop is not None:
            self._loop.run_ready()

    def has_other_tasks(self) -> bool:
        """Return whether a task of the script waits to run, apart from the one that asks."""
        return self._loop is not None and self._loop.has_other_tasks()

    def close(self) -> None:
        """Make `is_running` False: remaining tasks are not waited for. The first call tells who listens."""
        was_running, self._running = self._running, False
        if was_running:
            self._closing_listeners.call()


def get_app() -> App:
    """Return the application of the session (`omni.kit.app.get_app()`)."""
    return current().app
