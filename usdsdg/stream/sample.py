"""What one camera shows in one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.capture.tap import TappedView
from usdsdg.errors import AnnotatorError


@dataclass(frozen=True)
class Sample:
    """The annotations of one render product in one frame.

    Attributes:
        frame: index of the frame in its job, from 0.
        render_product: name of the render product.
        camera: prim path of its camera; of the first one of a tiled product.
        arrays: by annotator, the array that its `get_data` returns; annotators without one are missing. They belong to
            the sample.
        infos: by annotator, what else its `get_data` returns, such as `idToLabels`.
        classes: the class table of the dataset, labels by id, which is the same for all samples; where annotators have
            several label filters, that of the first annotator with labels.
        class_tables: by annotator whose label filter is another one, the class table of that filter.
    """

    frame: int
    render_product: str
    camera: str
    arrays: Mapping[str, np.ndarray]
    infos: Mapping[str, Mapping[str, Any]]
    classes: Mapping[int, Mapping[str, str]]
    class_tables: Mapping[str, Mapping[int, Mapping[str, str]]] = field(default_factory=dict)

    @classmethod
    def of(cls, view: TappedView) -> Sample:
        """Copy the annotations of a view."""
        return cls(
            view.frame,
            view.render_product,
            view.camera,
            {name: each.data.copy() for name, each in view.annotations.items() if each.data is not None},
            {name: _copied(each.info) for name, each in view.annotations.items()},
            view.classes,
            view.class_tables,
        )

    def class_ids(self, annotator: str) -> np.ndarray:
        """Return the ids of the rows of an annotator with a field "semanticId", int64 (N,).

        They are ids in `classes`, or in the annotator's table in `class_tables` where it has one.

        As in Isaac Sim, that field of boxes counts the labels of one frame; `idToLabels` of that frame says which they
        are. Of other annotators it is the id itself.

        Raises:
            KeyError: there is no such annotator, or it has no such rows.
            AnnotatorError: a setting lets ids count what each frame shows, so that the dataset has no class table.
        """
        try:
            rows = self.arrays[annotator]["semanticId"]
        except (IndexError, ValueError):
            raise KeyError(f"{annotator} has no field semanticId") from None
        labels = self.infos[annotator].get("idToLabels", {})
        if not all(isinstance(each, Mapping) for each in labels.values()) or "idToLabels" not in self.infos[annotator]:
            return rows.astype(np.int64)
        table = self.class_tables.get(annotator, self.classes)
        ids = {tuple(sorted(each.items())): number for number, each in table.items()}
        if unknown := [dict(each) for each in labels.values() if tuple(sorted(each.items())) not in ids]:
            raise AnnotatorError(
                f"stream: {annotator} has {unknown[0]}, which is in no class table: ids count what each frame "
                "shows, as the setting /usdsdg/labels/stableIds says. Leave it True, or read idToLabels of each "
                "sample's info."
            )
        of_frame = {int(number): ids[tuple(sorted(each.items()))] for number, each in labels.items()}
        return np.array([of_frame[int(each)] for each in rows], np.int64)


def _copied(info: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value.copy() if isinstance(value, (np.ndarray, dict)) else value for key, value in info.items()}
