"""BasicWriter's dense correspondence: where the points of an image are in that of another camera, or are now."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.basic_own import CORRESPONDENCE, OwnFiles
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Truth, points
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import beyond, of_pixels, shapes_agree

_STATES = 2  # 0: not in the other picture, 1: occluded there, 2: visible there
_PIXELS = 0.02
_DISTANCE = 1e-4  # by which recorded distances may be off, as a fraction


def check_correspondence(seen: Seen, files: OwnFiles, truth: Truth) -> Faults:
    """Pixels lead to where the points that they show are in the other picture; states are those of such places."""
    values, states, camera = files.values, files.picture, truth.camera
    if values is None or camera is None:
        return
    faults = list(shapes_agree(seen, files.file, values.shape, truth.product.shape))
    if states is not None:
        faults += shapes_agree(seen, files.picture_file, states.shape, truth.product.shape)
    yield from faults
    other = _other(seen, files, truth, camera)
    if isinstance(other, Fault):
        yield other
    if faults or isinstance(other, Fault):
        return
    width, height = (files.table or {}).get("resolution", (0, 0))
    if states is not None and files.table is not None:
        with np.errstate(invalid="ignore"):
            inside = ((values >= 0) & (values < (width, height))).all(axis=2)
        wrong = (states > _STATES) | ((states > 0) & ~inside)
        if wrong.any():
            what = f"only what is in the other picture is visible or occluded there, but {of_pixels(wrong)}"
            yield Fault(files.picture_file, seen.name, what)
    if not truth.parameter(CORRESPONDENCE, "captures"):
        yield from _placed(seen, files, truth, camera, other)


def _other(seen: Seen, files: OwnFiles, truth: Truth, camera: CameraView) -> CameraView | Fault | None:
    """Return the other picture's camera; a fault where the table names another; None: it is not recorded."""
    table: Mapping[str, object] | None = files.table
    if table is None:
        return None
    asked = truth.parameter(CORRESPONDENCE, "camera")
    recorded = [(each.path, each.cameras[0]) for each in truth.record.products if len(each.cameras) == 1]
    candidates = [view for path, view in recorded if asked in (path, view.prim_path)]
    if asked is None:
        candidates = [camera]
    found = table.get("camera"), table.get("resolution")
    fitting = [each for each in candidates if found == (each.prim_path, [each.width, each.height])]
    if candidates and not fitting:
        expected = " or ".join(f"{each.prim_path}, {each.width} x {each.height}" for each in candidates)
        return Fault(files.table_file, seen.name, "the other picture's camera and size", expected, str(found))
    return fitting[0] if fitting else None


def _placed(seen: Seen, files: OwnFiles, truth: Truth, camera: CameraView, other: CameraView | None) -> Faults:
    """Points of this picture are where the other camera shows them, and pixels without a point have no place."""
    values, shown = files.values, truth.product.gprim_image
    assert values is not None
    if shown is not None and (wrong := (shown < 0) & ~np.isnan(values).all(axis=2)).any():
        yield Fault(files.file, seen.name, f"what shows nothing has no place, but {of_pixels(wrong)}")
    if other is None or truth.product.depth is None:
        return
    rows, columns = truth.grid
    distance = truth.product.depth.astype(np.float64)
    found = values[rows, columns].reshape(-1, 2)
    expected, moved = (
        other.project(points(camera, scale * distance, rows, columns).reshape(-1, 3))[0]
        for scale in (1.0, 1.0 + _DISTANCE)
    )
    known = np.isfinite(expected).all(axis=1) & np.isfinite(moved).all(axis=1)
    limit = _PIXELS + np.abs(moved - expected)[known]
    wrong = beyond(np.abs(found - expected)[known], limit).any(axis=1)
    if wrong.any():
        first = int(wrong.argmax())
        yield Fault(
            files.file, seen.name,
            f"{int(wrong.sum())} of {int(known.sum())} points are elsewhere in {other.prim_path}",
            str(expected[known][first].tolist()), str(found[known][first].tolist()),
        )  # fmt: skip
