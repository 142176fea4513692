"""One captured picture with everything known about it: the record that annotators turn into labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.errors import AnnotatorError

if TYPE_CHECKING:
    from usdsdg.annotators.labeled_prims import LabeledPrims, Selection
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg.stage.geometry.pixel_masks import Outlines

# Columns of `Frame.coverage`.
PIXELS, X_MIN, Y_MIN, X_MAX, Y_MAX = range(5)


@dataclass(frozen=True)
class Frame:
    """The AOVs of one render product at one instant, with the labelled things in front of its camera.

    Arrays are shared, never copied: nobody may write into them, also not later.
    """

    index: int  # how many captures came before it
    camera: CameraView
    render_product: str  # prim path
    aovs: Mapping[str, np.ndarray]  # name → (H, W[, C]); see the renderer's list
    gprims: tuple[str, ...]  # prim path of every value of the "instance" AOV; -1 there means no hit
    labeled_prims: LabeledPrims
    amodal_masks: Outlines  # of all labeled prims, by row; with the visible part of each
    reference_time: tuple[int, int] = (0, 1)
    memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def aov(self, name: str) -> np.ndarray:
        """The AOV called `name`.

        Raises:
            AnnotatorError: it was not rendered, so the annotator declares too little.
        """
        try:
            return self.aovs[name]
        except KeyError:
            raise AnnotatorError(
                f"{self.render_product}: AOV {name!r} was not rendered for this frame (there are: "
                f"{', '.join(sorted(self.aovs)) or 'none'}). Attach the annotator before the step that it should see."
            ) from None

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) in pixels."""
        return self.camera.height, self.camera.width

    @property
    def coverage(self) -> np.ndarray:
        """(len(labeled_prims), 5) int64: pixels, x_min, y_min, x_max, y_max that each would cover alone."""
        return self.amodal_masks.coverage

    def selection(self, predicate: str | None) -> Selection:
        """The entities whose labels pass the filter `predicate`; None lets every label pass."""
        return self.labeled_prims.select(predicate)

    def members(self, predicate: str | None) -> np.ndarray:
        """(H, W) int32: index into `selection(predicate)` of what each pixel shows, -1 for everything else."""
        # The appended -1 is what a pixel without a hit, index -1, looks up.
        return self.derive(
            ("members", predicate),
            lambda: np.append(self.selection(predicate).member_of_gprim, np.int32(-1))[self.aov("instance")],
        )

    def visible_pixels(self, predicate: str | None) -> np.ndarray:
        """(K,) int64: in how many pixels each of the K selected entities is seen."""
        count = len(self.selection(predicate))
        return self.derive(
            ("visible_pixels", predicate),
            lambda: np.bincount(self.members(predicate).ravel() + 1, minlength=count + 1)[1:],
        )

    def occlusion(self, predicate: str | None) -> np.ndarray:
        """(K,) float32: hidden share of the pixels that each would cover alone; nan out of view."""
        alone = self.coverage[self.selection(predicate).rows, PIXELS]
        ratio = np.full(len(alone), np.nan, np.float32)
        np.divide(alone - self.visible_pixels(predicate), alone, out=ratio, where=alone > 0, casting="unsafe")
        return ratio

    def derive(self, key: Any, make: Callable[[], Any]) -> Any:
        """What `make` returns, computed once per frame and `key`."""
        if key not in self.memo:
            self.memo[key] = make()
        return self.memo[key]
