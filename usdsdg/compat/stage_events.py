"""Events of the stage and of rendering, by number as before Isaac Sim 6, and by name in `carb.eventdispatcher`."""

from __future__ import annotations

import enum
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from usdsdg.app.app import get_app
from usdsdg.compat.carb.events import IEvent, IEventStream, ISubscription
from usdsdg.compat.new_frames import NewFrames
from usdsdg.errors import warn_once
from usdsdg.session import stage_context
from usdsdg.session.session import current
from usdsdg.session.timeline import get_timeline

_STAGE, _RENDERING = "omni.usd::stage:", "omni.usd.context:"


class StageEventType(enum.IntEnum):
    """The types of stage events, with Kit's numbers; those of `SENT_STAGE_EVENTS` happen here."""

    SAVED = 0
    SAVE_FAILED = 1
    OPENING = 2
    OPENED = 3
    OPEN_FAILED = 4
    CLOSING = 5
    CLOSED = 6
    SELECTION_CHANGED = 7
    ASSETS_LOADED = 8
    ASSETS_LOAD_ABORTED = 9
    GIZMO_TRACKING_CHANGED = 10
    MDL_PARAM_LOADED = 11
    SETTINGS_LOADED = 12
    SETTINGS_SAVING = 13
    OMNIGRAPH_START_PLAY = 14
    OMNIGRAPH_STOP_PLAY = 15
    SIMULATION_START_PLAY = 16
    SIMULATION_STOP_PLAY = 17
    ANIMATION_START_PLAY = 18
    ANIMATION_STOP_PLAY = 19
    DIRTY_STATE_CHANGED = 20
    ASSETS_LOADING = 21
    ACTIVE_LIGHT_COUNTS_CHANGED = 22
    HIERARCHY_CHANGED = 23
    HYDRA_GEOSTREAMING_STARTED = 24
    HYDRA_GEOSTREAMING_STOPPED = 25
    HYDRA_GEOSTREAMING_STOPPED_NOT_ENOUGH_MEM = 26
    HYDRA_GEOSTREAMING_STOPPED_AT_LIMIT = 27
    SAVING = 28
    COUNT = 29


class StageRenderingEventType(enum.IntEnum):
    """The types of rendering events, with Kit's numbers; only new frames happen here."""

    NEW_FRAME = 0
    HYDRA_ENGINE_FRAMES_COMPLETE = 1
    HYDRA_ENGINE_FRAMES_ADDED = 2
    RENDERER_RECORDING_COMPLETE = 3
    COUNT = 4


class StageState(enum.IntEnum):
    """The states of a context; there is always an open stage."""

    CLOSED = 0
    OPENING = 1
    OPENED = 2
    CLOSING = 3


SENT_STAGE_EVENTS = frozenset(
    {
        StageEventType.SAVING, StageEventType.SAVED, StageEventType.SAVE_FAILED, StageEventType.OPENING,
        StageEventType.OPENED, StageEventType.OPEN_FAILED, StageEventType.CLOSING, StageEventType.CLOSED,
        StageEventType.SELECTION_CHANGED, StageEventType.ASSETS_LOADED, StageEventType.SIMULATION_START_PLAY,
        StageEventType.SIMULATION_STOP_PLAY, StageEventType.ANIMATION_START_PLAY, StageEventType.ANIMATION_STOP_PLAY,
    }
)  # fmt: skip


class _KindsStream(IEventStream):
    """A stream that warns who waits for types of events that never happen."""

    def __init__(self, name: str, kinds: type[enum.IntEnum], sent: Collection[int]) -> None:
        super().__init__(name)
        self._kinds, self._sent = kinds, sent

    def _subscribe(self, event_type: int | None, fn: Callable[[IEvent], Any], order: int) -> ISubscription:
        if event_type is not None:
            warn_if_never(self._kinds(event_type), self._sent)
        return super()._subscribe(event_type, fn, order)


class StageEvents:
    """Sends events of stages and new frames to both streams, and those of stages to the event dispatcher.

    Where a stage is replaced: CLOSING before it, then CLOSED, OPENING and OPENED; at the next app update ASSETS_LOADED,
    since assets are loaded when the stage is.
    """

    def __init__(self) -> None:
        self.stage: IEventStream = _KindsStream("stage", StageEventType, SENT_STAGE_EVENTS)
        self.rendering: IEventStream = _KindsStream(
            "rendering", StageRenderingEventType, {StageRenderingEventType.NEW_FRAME}
        )
        self._loading = True  # whether ASSETS_LOADED is to be sent
        self._playing = not get_timeline().is_stopped()
        stage_context.on_stage_closing(lambda _stage: self.send(StageEventType.CLOSING))
        stage_context.on_new_stage(lambda _stage: self._on_new_stage())
        get_app().subscribe_update(lambda _dt: self._on_update())
        get_timeline().subscribe(self._on_timeline)
        NewFrames(self._on_new_frame)

    def send(self, kind: StageEventType, payload: Mapping[str, Any] | None = None) -> None:
        """Deliver one stage event."""
        self.stage.push(kind, payload=payload)
        for dispatcher in current()._made("event_dispatcher"):
            dispatcher.dispatch_event(stage_event_name(kind), payload)

    @contextmanager
    def saving(self, file: str) -> Iterator[None]:
        """Send SAVING, and at the end of the block SAVED, or SAVE_FAILED after an error."""
        self.send(StageEventType.SAVING, {"savingRootLayer": file})
        try:
            yield
        except BaseException:
            self.send(StageEventType.SAVE_FAILED)
            raise
        self.send(StageEventType.SAVED, {"savedLayers": [file]})

    @contextmanager
    def opening(self) -> Iterator[None]:
        """Send OPEN_FAILED after an error in the block."""
        try:
            yield
        except BaseException:
            self.send(StageEventType.OPEN_FAILED)
            raise

    def _on_new_stage(self) -> None:
        self._loading = True
        for kind in (StageEventType.CLOSED, StageEventType.OPENING, StageEventType.OPENED):
            self.send(kind)

    def _on_update(self) -> None:
        if self._loading:
            self._loading = False
            self.send(StageEventType.ASSETS_LOADED)

    def _on_timeline(self, change: str) -> None:
        if change == "play" and not self._playing:
            self._playing = True
            self.send(StageEventType.SIMULATION_START_PLAY)
            self.send(StageEventType.ANIMATION_START_PLAY)
        elif change == "stop" and self._playing:
            self._playing = False
            self.send(StageEventType.SIMULATION_STOP_PLAY)
            self.send(StageEventType.ANIMATION_STOP_PLAY)

    def _on_new_frame(self, number: int) -> None:
        self.rendering.push(StageRenderingEventType.NEW_FRAME, payload={"swh_frame_number": number})


def stage_events() -> StageEvents:
    """Return the stage events of the session."""
    return current().stage_events


def stage_event_name(kind: StageEventType) -> str:
    """Return the name of a stage event in `carb.eventdispatcher`."""
    return f"{_STAGE}{StageEventType(kind).name.lower()}"


def stage_event_type(name: str) -> StageEventType | None:
    """Return the type of the stage event that has a name, None for another name."""
    member = name.removeprefix(_STAGE).upper()
    return StageEventType.__members__.get(member) if name.startswith(_STAGE) else None


def rendering_event_name(kind: StageRenderingEventType) -> str:
    """Return the name of a rendering event in `carb.eventdispatcher`."""
    return f"{_RENDERING}{StageRenderingEventType(kind).name.lower()}"


def warn_if_never(kind: enum.IntEnum, sent: Collection[int]) -> None:
    """Warn where a type of events never happens."""
    if kind not in sent:
        happen = ", ".join(each.name for each in type(kind) if each in sent)
        warn_once(f"omni.usd.{type(kind).__name__}.{kind.name} never happens; those that do are {happen}")
