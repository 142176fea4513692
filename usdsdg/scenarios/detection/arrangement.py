"""The arrangement of one frame: objects and distractors, drawn until what is hidden and cut off is as wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdsdg.scenarios.detection.config import DetectionConfig
from usdsdg.scenarios.detection.placement import Place, draw_distractor, draw_in_front, draw_place, is_free
from usdsdg.scenarios.detection.sight import Seen, measure
from usdsdg.scenarios.draws import Draws
from usdsdg.scenarios.shared.bodies import Body
from usdsdg.stage.cameras.camera_view import CameraView

ROUNDS = 8  # of drawing and measuring; what is hidden or cut off too much then is left out
_TRIES = 30  # for a place that is free
# An object with less than this counts as whole.
HIDDEN, CUT = 0.05, 0.02


@dataclass
class _Row:
    """An object of the frame, what of it should be missing, and where it is; `front` hides a part of it."""

    body: Body
    occluded: bool
    truncated: bool
    front: Body | None
    place: Place | None = None
    front_place: Place | None = None


@dataclass(frozen=True)
class Arranger:
    """Arranges frames in the view of a camera, which sees the frame of the bodies' parent."""

    config: DetectionConfig
    draws: Draws
    view: CameraView
    camera: Usd.Prim

    def arrange(self, frame: int, objects: Sequence[Body], distractors: Sequence[Body]) -> float:
        """Place the bodies of a frame, hiding those for which there is no place; return the farthest distance."""
        rows, clutter = self._roles(frame, objects, distractors)
        wrong: Sequence[int] = range(len(rows))
        for attempt in range(ROUNDS):
            for number in wrong:
                self._place(rows, number, self.draws.generator(f"object/{number}/{attempt}", frame))
            wrong = self._wrong(rows, hopeful=attempt < ROUNDS - 2)
            if not wrong:
                break
        for number in wrong:
            self._leave_out(rows[number])
        return self._place_clutter(frame, rows, clutter)

    def _roles(self, frame: int, objects: Sequence[Body], distractors: Sequence[Body]) -> tuple[list[_Row], list[Body]]:
        """Return the objects, with a distractor in front of some, and the other distractors."""
        generator, free = self.draws.generator("roles", frame), list(distractors)
        rows = []
        for body in objects:
            occluded, truncated = generator.random(2) < (self.config.occlusion.share, self.config.truncation.share)
            front = free.pop() if occluded and free else None
            rows.append(_Row(body, bool(occluded and front), bool(truncated), front))
        return rows, free

    def _place(self, rows: Sequence[_Row], number: int, generator: np.random.Generator) -> None:
        row, sizes = rows[number], self.config.objects.size_in_image
        others = [each.place for each in rows if each is not row and each.place is not None]
        for _ in range(_TRIES):
            row.place = draw_place(generator, self.view, row.body.radius, sizes, cut_off=row.truncated)
            if is_free(row.place, others):
                break
        assert row.place is not None
        row.body.place(row.place.center, row.place.turn)
        row.body.show(True)
        if row.front is not None:
            row.front_place = draw_in_front(generator, self.view, row.place, self.config.distractors.size_in_image)
            _put(row.front, row.front_place, generator)

    def _wrong(self, rows: Sequence[_Row], *, hopeful: bool) -> list[int]:
        """Return the objects that are not as they should be; at last only those with too little left."""
        placed = [number for number, row in enumerate(rows) if row.place is not None]
        seen = measure(self.camera, (self.view.width, self.view.height), [rows[number].body.prim for number in placed])
        return [number for number, each in zip(placed, seen) if not self._is_right(rows[number], each, hopeful)]

    def _is_right(self, row: _Row, seen: Seen, hopeful: bool) -> bool:
        occlusion, truncation = self.config.occlusion.most, self.config.truncation.most
        if seen.occlusion > occlusion or seen.truncation > truncation or seen.pixels == 0:
            return False
        if not hopeful:
            return True
        hidden, cut = seen.occlusion > min(HIDDEN, occlusion), seen.truncation > min(CUT, truncation)
        return hidden == (row.occluded and occlusion > HIDDEN) and cut == (row.truncated and truncation > CUT)

    def _leave_out(self, row: _Row) -> None:
        row.body.show(False)
        if row.front is not None:
            row.front.show(False)
        row.place = row.front_place = None

    def _place_clutter(self, frame: int, rows: Sequence[_Row], clutter: Sequence[Body]) -> float:
        """Put the other distractors behind the objects, which they do not hide then; return the farthest distance."""
        places = [place for row in rows for place in (row.place, row.front_place) if place is not None]
        behind = max((place.distance + place.radius for place in places), default=1.0)
        far = behind
        for number, body in enumerate(clutter):
            generator = self.draws.generator(f"clutter/{number}", frame)
            sizes = self.config.distractors.size_in_image
            place = draw_distractor(generator, self.view, sizes, behind * generator.uniform(1.0, 1.8))
            # Its near side is behind the objects.
            place = place.moved(1.0 + place.radius / place.distance)
            _put(body, place, generator)
            far = max(far, place.distance + place.radius)
        return far


def _put(body: Body, place: Place, generator: np.random.Generator) -> None:
    """Show a distractor at a place, in its size, shapes stretched."""
    stretch = generator.uniform(0.4, 1.0, 3) if body.can_stretch else np.ones(3)
    body.place(place.center, place.turn, size=place.radius / body.radius, stretch=stretch.tolist())
    body.paint(generator)
    body.show(True)
