"""BasicWriter's keypoints, and coordinates in the boxes of objects."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.basic_own import OwnFiles
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Truth
from usdsdg.verify.checks.compare import beyond, differs, of_pixels, text
from usdsdg.verify.checks.points import are_elsewhere

_FLOAT32 = 2e-6
_PIXELS = 0.02
_OUTSIDE, _OCCLUDED, _VISIBLE = 0, 1, 2
_UNLABELLED = 1
_LEVELS = 255


def check_keypoints(seen: Seen, files: OwnFiles, truth: Truth) -> Faults:
    """Rows are those of the recorded keypoints: whose they are, and where in the world and in the picture."""
    rows, table, camera = files.values, files.table, truth.camera
    if rows is None or camera is None:
        return
    recorded = [
        (each.owners.get(files.filter, ""), name, position)
        for each in truth.product.keypoints
        for name, position in zip(each.names, each.positions)
    ]
    if len(rows) != len(recorded):
        yield Fault(files.file, seen.name, "keypoints are those of the stage", str(len(recorded)), str(len(rows)))
        return
    names = sorted({name for _, name, _ in recorded})
    if table is not None and (table.get("keypointNames") != names or len(table.get("primPaths") or ()) != len(rows)):
        expected, found = f"{names}, {len(rows)} paths", f"{table.get('keypointNames')}, {table.get('primPaths')}"
        yield Fault(files.table_file, seen.name, "names of keypoints, and paths of their prims", expected, found)
    ids = {each.path: (each.id, each.class_id) for each in truth.things(files.filter)}
    positions = np.array([position for *_, position in recorded]).reshape(-1, 3)
    pixels, _ = camera.project(positions)
    near = np.minimum(np.abs(pixels), np.abs(pixels - (camera.width, camera.height))).min(axis=1)
    inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)
    outside = set(np.flatnonzero(~inside & (near > _PIXELS)).tolist())
    for index, (owner, name, position) in enumerate(recorded):
        row, what = rows[index], f"the keypoint {name} of {owner or 'no object'}"
        expected = (*ids.get(owner, (None, None)), names.index(name))
        found = tuple(int(row[key]) for key in ("instanceId", "semanticId", "keypointId"))
        # What is out of view has ids, too, which the record does not have.
        if found[2] != expected[2] or (owner in ids and found != expected) or (not owner and found[0] != _UNLABELLED):
            yield Fault(files.file, seen.name, f"ids of {what}", str(expected), str(found))
        if differs(row["position"], position, relative=_FLOAT32):
            yield Fault(files.file, seen.name, f"the position of {what}", text(position), text(row["position"]))
        place, shown = (row["x"], row["y"]), pixels[index]
        if np.isfinite(shown).all() and differs(place, shown, relative=_FLOAT32, absolute=_PIXELS):
            yield Fault(files.file, seen.name, f"{what} [pixels]", text(shown), text(place))
        if row["visibility"] not in (_OUTSIDE, _OCCLUDED, _VISIBLE):
            yield Fault(files.file, seen.name, f"visibility of {what}", "0, 1 or 2", str(row["visibility"]))
        elif row["visibility"] and index in outside:
            yield Fault(files.file, seen.name, f"{what} is not in the picture", "0", str(row["visibility"]))
        elif bool(row["hiddenBy"]) != (row["visibility"] == _OCCLUDED):
            yield Fault(files.file, seen.name, f"{what} is occluded by something", "", str(row["hiddenBy"]))
        if camera.projection_type == "pinhole" and camera.lens is None:
            away = float(np.linalg.norm(position - camera.local_to_world[3, :3])) * camera.meters_per_unit
            if differs(row["distance"], away, relative=1e-5):
                yield Fault(files.file, seen.name, f"the distance of {what}", f"{away:.6g}", str(row["distance"]))


def check_coordinates(seen: Seen, files: OwnFiles, truth: Truth) -> Faults:
    """Coordinates lead to the points that are seen, by the boxes of the objects."""
    values, members = files.values, truth.members(files.filter)
    if members is None or values is None:
        return
    if values.shape != (*members.shape, 4):
        yield Fault(files.file, seen.name, "has another size", str((*members.shape, 4)), str(values.shape))
        return
    things = truth.things(files.filter)
    wrong = (values[..., 3] != (members >= 0)) | beyond(np.abs(values - 0.5).max(axis=2), 0.5 + 1e-3)
    wrong |= (members < 0) & values.any(axis=2)
    if wrong.any():
        yield Fault(files.file, seen.name, f"coordinates are where objects are, but {of_pixels(wrong)}")
    yield from _boxes(seen, files, truth)
    if truth.grid_points is not None and truth.camera is not None and things:
        rows, columns = truth.grid
        here = members[rows, columns] >= 0
        owners = members[rows, columns][here]
        low, high = (np.array([each.bounds[end] for each in things])[owners] for end in (0, 1))
        local = low + values[rows, columns][here][:, :3] * (high - low)
        matrices = np.array([each.local_to_world for each in things])[owners]
        world = np.einsum("ni,nij->nj", local, matrices[:, :3, :3]) + matrices[:, 3, :3]
        if are_elsewhere(world, truth.grid_points[here], truth.camera):
            yield Fault(files.file, seen.name, "coordinates do not lead to the points that are seen")
    if files.picture is not None:
        off = np.abs(files.picture[..., :4].astype(np.float64) - _LEVELS * values[..., : files.picture.shape[2]])
        wrong = np.any(beyond(off, 1.0 + 1e-3), axis=2)
        if wrong.any():
            what = f"levels are those of {files.file}, but {of_pixels(wrong)}"
            yield Fault(files.picture_file, seen.name, what)


def _boxes(seen: Seen, files: OwnFiles, truth: Truth) -> Faults:
    """The table has the boxes of what is visible."""
    table = files.table
    if table is None:
        return
    shown = [each for each in truth.things(files.filter) if each.visible]
    for key, expected in (
        ("instanceIds", [each.id for each in shown]), ("primPaths", [each.path for each in shown])
    ):  # fmt: skip
        if table.get(key) != expected:
            yield Fault(files.table_file, seen.name, key, str(expected), str(table.get(key)))
    boxes = np.array([each.bounds for each in shown]).reshape(-1, 2, 3)
    if differs(np.reshape(table.get("boxes") or [], (-1, 2, 3)), boxes, relative=_FLOAT32):
        yield Fault(files.table_file, seen.name, "boxes", text(boxes), text(table.get("boxes") or []))
