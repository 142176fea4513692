"""Render products between captures, as the application shows them after its latest update.

Nothing is rendered until an annotator is read: then its product is rendered, unless nothing has changed since the frame
that the annotator holds.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass, replace
from typing import Any

from pxr import Tf, Usd

from usdsdg.annotators.annotator import Annotator
from usdsdg.capture.capture import Capture
from usdsdg.capture.render_settings import render_mode
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


@dataclass(frozen=True)
class Moment:
    """What an image of the stage depends on."""

    update: int  # of the application
    edits: int  # of the stage
    time: float  # on the timeline [s]
    settings: dict[str, Any]  # those that differ from their defaults
    label_filters: int  # how often the filter of all labels was set

    def shows_the_same_as(self, other: Moment) -> bool:
        """Return whether images of both are equal, but for the noise of colors."""
        return replace(self, update=other.update) == other


class LiveView:
    """Brings annotators that users have attached up to date with the application's updates, when they are read."""

    def __init__(self) -> None:
        self._edits = 0
        self._stage: Usd.Stage | None = None
        self._listener: Tf.Notice.Listener | None = None
        # The ids in images between captures are those of captured frames.
        self._capture = Capture(shared_prims=lambda: current().orchestrator.capture.labeled_prims())
        self._seen: weakref.WeakKeyDictionary[Annotator, Moment] = weakref.WeakKeyDictionary()

    def reset(self) -> None:
        """Forget the stage, as a new one does."""
        if self._listener is not None:
            self._listener.Revoke()
        self.__init__()

    def note(self, annotator: Annotator) -> None:
        """Remember that the annotator is up to date: it was attached or computed now."""
        self._seen[annotator] = self._now()

    def refresh(self, annotator: Annotator) -> None:
        """Compute the annotator again if the application was updated since, and what it shows may have changed."""
        seen, now = self._seen.get(annotator), self._now()
        if seen is None or seen.update == now.update:
            return
        product = current().render_products.get(annotator.render_product or "")
        if product is not None and not product.updates_enabled:
            return  # what has changed meanwhile shows when it is enabled again
        self._seen[annotator] = now
        if annotator.has_data and seen.shows_the_same_as(now):
            return
        self._show(annotator, now)

    def show(self, annotator: Annotator) -> None:
        """Compute the annotator for the stage as it is, before any update of the application."""
        now = self._seen[annotator] = self._now()
        self._show(annotator, now)

    def _show(self, annotator: Annotator, now: Moment) -> None:
        path = annotator.render_product
        assert path is not None
        mode = render_mode(max(get_settings().get_as_int("/omni/replicator/RTSubframes"), 1))
        self._capture.show(path, mode, number=now.update, seconds=now.time)

    def _now(self) -> Moment:
        self._count_edits()
        state = current()
        return Moment(
            state.app.get_update_number(),
            self._edits,
            get_timeline().get_current_time(),
            get_settings().changed(),
            state.label_filter_sets,
        )

    def _count_edits(self) -> None:
        stage = current().stage
        if stage is not self._stage and stage is not None:
            self._stage = stage
            # pxr holds the method weakly, so that the listener does not keep the view alive.
            self._listener = Tf.Notice.Register(Usd.Notice.ObjectsChanged, self._count, stage)

    def _count(self, notice: Usd.Notice.ObjectsChanged, sender: Usd.Stage) -> None:
        self._edits += 1
