"""The application: one update after another, as `omni.kit.app` gives it.

One update, always in this order: events and pending nodes of the graph → timeline → physics → update listeners.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from usdsdg import engines, render_product
from usdsdg.graph import evaluate
from usdsdg.settings import get_settings
from usdsdg.stage import context
from usdsdg.timeline import get_timeline
from usdsdg.writers.backends import set_disk_root
from usdsdg.writers.io_queue import set_max_queue_size

IDLE_SECONDS = 0.002  # pause of the update driver while nobody waits


class App:
    """Updates on demand: an update happens when a script calls `update` or awaits the next one."""

    def __init__(self) -> None:
        self._listeners: list[Callable[[float], None]] = []
        self._waiters: list[asyncio.Future[None]] = []
        self._updates = 0
        get_timeline().subscribe(self._on_timeline)
        context.on_new_stage(self._on_new_stage)
        settings = get_settings()
        settings.on_change("/omni/replicator/backends/disk/root_dir", lambda root: set_disk_root(root or None))
        settings.on_change("/omni/replicator/backend/queueSize", set_max_queue_size)

    # --- updates ---
    def update(self) -> None:
        """One application update; while the timeline plays it advances by one time code."""
        timeline = get_timeline()
        evaluate.graph().evaluate(time=timeline.get_current_time())
        dt = 1.0 / timeline.get_time_codes_per_seconds()
        if timeline.is_playing() and timeline.is_auto_updating():
            self.advance(dt)
        self._updates += 1
        for listener in list(self._listeners):
            listener(dt)

    def advance(self, seconds: float) -> None:
        """Move timeline and physics on by `seconds`."""
        get_timeline().advance(seconds)
        if get_settings().get_as_bool("/app/player/playSimulations"):
            engines.physics().advance(seconds)

    async def next_update_async(self) -> float:
        """Wait for one more update. All who wait see the same one."""
        loop = asyncio.get_running_loop()
        waiter: asyncio.Future[None] = loop.create_future()
        self._waiters.append(waiter)
        await waiter
        return 1.0 / get_timeline().get_time_codes_per_seconds()

    pre_update_async = post_update_async = next_update_async

    def subscribe_update(self, listener: Callable[[float], None]) -> Callable[[], None]:
        """Call `listener(dt)` after each update; returns what ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener) if listener in self._listeners else None

    def get_update_number(self) -> int:
        return self._updates

    def is_running(self) -> bool:
        return True

    # --- the event loop of scripts ---
    def run(self, start: Callable[[], Any]) -> None:
        """Call `start` inside an event loop and update until every task that it left has ended.

        An exception of a task ends the run and is raised here.
        """
        asyncio.run(self._drive(start))

    def run_until_complete(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Run one coroutine to its end, with updates while it waits for them."""
        result: list[Any] = []

        async def keep() -> None:
            result.append(await work)

        self.run(lambda: asyncio.ensure_future(keep()))
        return result[0]

    async def _drive(self, start: Callable[[], Any]) -> None:
        driver = asyncio.current_task()
        ended: list[asyncio.Task[Any]] = []
        asyncio.get_running_loop().set_task_factory(lambda loop, coro, **kw: _watched(loop, coro, ended, **kw))
        start()
        while True:
            await asyncio.sleep(0)
            _raise_unseen(ended)
            if self._waiters:
                self._serve()
            elif len(asyncio.all_tasks() - {driver}) == 0:
                break
            else:
                await asyncio.sleep(IDLE_SECONDS)
        await asyncio.sleep(0)
        _raise_unseen(ended)

    def _serve(self) -> None:
        waiters, self._waiters = self._waiters, []
        try:
            self.update()
        except Exception as error:  # noqa: BLE001 - whoever waits for the update gets its failure
            for waiter in waiters:
                if not waiter.done():
                    waiter.set_exception(error)
            return
        for waiter in waiters:
            if not waiter.done():
                waiter.set_result(None)

    # --- reactions ---
    def _on_timeline(self, event: str) -> None:
        if event == "play":
            engines.physics().play()
        elif event == "stop" and (physics := engines.physics_if_made()) is not None:
            physics.stop()

    def _on_new_stage(self, *_: Any) -> None:
        get_timeline().reset()
        engines.reset()
        evaluate.reset()
        render_product.reset()


def _watched(loop: Any, coro: Any, ended: list[asyncio.Task[Any]], **options: Any) -> asyncio.Task[Any]:
    task = asyncio.Task(coro, loop=loop, **options)
    task.add_done_callback(ended.append)
    return task


def _raise_unseen(ended: list[asyncio.Task[Any]]) -> None:
    """Raise the failure of a task that nobody awaited; whoever awaits a task has its failure already."""
    while ended:
        task = ended.pop(0)
        # True until somebody retrieves the exception: asyncio's own test for "never retrieved".
        if not task.cancelled() and getattr(task, "_log_traceback", True):
            error = task.exception()
            if error is not None:
                raise error


_app: App | None = None


def get_app() -> App:
    """The process-wide application (`omni.kit.app.get_app()`)."""
    global _app
    if _app is None:
        _app = App()
    return _app
