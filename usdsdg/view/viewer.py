"""The viewer: the loop in which the thread that owns the engines does what pages ask for, and draws."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

from usdsdg.errors import UsdsdgError
from usdsdg.graph.sampling import get_global_seed
from usdsdg.session.endings.termination import between_frames
from usdsdg.session.timeline import get_timeline
from usdsdg.view import asking, triggers
from usdsdg.view.channel import Channel
from usdsdg.view.drawing import MODES, PATHS
from usdsdg.view.open_page import OpenPage
from usdsdg.view.playing import Playing
from usdsdg.view.scene import Scene

# How often a loop without work looks for signals, and one that plays for the next time code [s].
_IDLE_SECONDS, _PLAYING_SECONDS = 0.2, 0.002


class Viewer:
    """Shows the current stage to all pages. All its methods but `opened` and `wake` are for one thread.

    Args:
        title: what the pages are headed with.
    """

    def __init__(self, title: str) -> None:
        self._title = title
        self._scene = Scene()
        self._playing = Playing(self._scene)
        self._pages: list[OpenPage] = []
        self._new: queue.SimpleQueue[Channel] = queue.SimpleQueue()
        self._awake = threading.Event()
        self._seed: int | None = None  # of the triggers that were run again
        self._frame: int | None = None  # that a script has stopped at
        self._goes_on = False  # to the next frame
        self._busy = ""

    # --- for the server's thread ---
    def opened(self, channel: Channel) -> None:
        """Take a new page."""
        self._new.put(channel)
        self._awake.set()

    def wake(self) -> None:
        """Look at what pages have asked for."""
        self._awake.set()

    # --- the loop ---
    def run(self, *, frame: int | None = None, until: Callable[[], bool] = lambda: False) -> None:
        """Show the stage until `until` is true, or, with `frame`, until a page asks for the next one.

        frame: the number of the frame at which a script has stopped; None: nothing comes next.
        """
        self._frame, self._goes_on, self._seed, self._busy = frame, False, None, ""
        self._scene.change()
        with between_frames():
            self._scene.read()
            self._describe()
            while not (self._goes_on or until()):
                self._awake.clear()
                self._turn()
        self._playing.restore()
        self._say_busy("the next frame is being made")

    def _turn(self) -> None:
        """Do everything once, and wait where nothing is to be done."""
        self._welcome()
        for page in self._pages:
            page.hear()
        try:
            self._playing.follow()
        except UsdsdgError as error:
            self._playing.pause()
            self._tell_error(error)
        moving = self._playing.is_playing
        drew = [page.draw(is_moving=moving) for page in self._pages]
        self._tell_state()
        if not any(drew):
            longest = _PLAYING_SECONDS if moving else _IDLE_SECONDS
            self._awake.wait(min([longest, *(page.seconds_to_wait for page in self._pages)]))

    def _welcome(self) -> None:
        self._pages = [page for page in self._pages if page.channel.is_open]
        while not self._new.empty():
            page = OpenPage(self._new.get(), self._scene, self._do)
            self._pages.append(page)
            self._describe()

    def _do(self, wish: asking.Asking) -> None:
        """Do what a page asks for that concerns all of them."""
        match wish:
            case asking.Randomize():
                self._say_busy("the triggers run")
                try:
                    triggers.run_again(wish.seed)
                finally:
                    self._seed = wish.seed
                    self._scene.change()
                    self._say_busy("")
                    self._describe()
            case asking.Simple(do="next"):
                self._goes_on = self._frame is not None
            case asking.Simple(do="play" | "step"):
                self._say_busy("physics starts")
                try:
                    self._playing.play() if wish.do == "play" else self._playing.step()
                finally:
                    self._say_busy("")
            case asking.Simple():
                self._playing.pause() if wish.do == "pause" else self._playing.reset()

    # --- what pages are told ---
    def _describe(self) -> None:
        """Tell all pages what the stage has."""
        self._scene.read()
        scene = {
            "title": self._title,
            "modes": [PATHS, *MODES],
            "cameras": [{"path": each.path, "size": list(each.size)} for each in self._scene.cameras()],
            "triggers": triggers.names(),
            "notes": list(self._scene.notes),
            "gprims": len(self._scene.table.gprims),
            "device": self._scene.read().device,
        }
        for page in self._pages:
            page.tell(scene=scene)
        self._tell_state()

    def _tell_state(self) -> None:
        state: dict[str, Any] = {
            "playing": self._playing.is_playing,
            "time": round(get_timeline().get_current_time(), 4),
            "seed": get_global_seed() if self._seed is None else self._seed,
            "frame": self._frame,
            "busy": self._busy,
        }
        for page in self._pages:
            page.tell(state=state)

    def _say_busy(self, what: str) -> None:
        self._busy = what
        self._tell_state()

    def _tell_error(self, error: UsdsdgError) -> None:
        for page in self._pages:
            page.tell_error(error)
