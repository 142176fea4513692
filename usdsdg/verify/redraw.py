"""Frames rendered again from the recorded stage: finds faults of the record itself, such as a wrong prim's label.

What is compared is read anew: ids and depth from rays, poses and labels from the stage, by ways of their own.
"""

from __future__ import annotations

import gzip
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.annotators.ownership import parse_filter
from usdsdg.annotators.point_instances import prim_path
from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.folder import Folder
from usdsdg.errors import UsdsdgError
from usdsdg.record import samples
from usdsdg.record.frame_record import FrameRecord, ProductRecord
from usdsdg.session import engines, stage_context
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.geometry.face_parts import read_face_parts
from usdsdg.stage.semantics.label_filter import LabelFilter
from usdsdg.stage.semantics.labels import get_labels, is_labeled
from usdsdg.stores.temporary import TemporaryFolder
from usdsdg.verify.checks.compare import differs, text
from usdsdg.verify.recorded_assets import RecordedAssets
from usdsdg.verify.stage_bounds import bounds_below, bounds_of, bounds_of_part

AOVS = ("instance", "distance_to_camera")
# Where surfaces coincide either may be in front.
_ODD = 0.002
_DEPTH = 1e-4
_OF_SIZE = 1e-3


def redraw(
    data: Folder, numbers: Sequence[int] | None, *, most: int, progress: Callable[[str, int, int | None], None] | None
) -> tuple[list[Fault], list[str], int]:
    """Render recorded frames again; return the faults, notes about what could not be rendered, and how many were.

    numbers: those of the frames; None: `most` of them, evenly spaced.
    """
    chosen = [each for each in data.records if numbers is None or each.number in numbers]
    if numbers is None and len(chosen) > most:
        chosen = [chosen[index] for index in np.linspace(0, len(chosen) - 1, most).astype(int)]
    faults: list[Fault] = []
    notes = [] if chosen else ["no frame of these numbers is recorded"]
    rendered, recorded = 0, RecordedAssets(data.path)
    for done, record in enumerate(chosen, 1):
        if not record.stage:
            notes.append(f"frame {record.number}: the stage is not recorded, so it cannot be rendered again")
            continue
        if not data.has(str(record.stage["file"])):
            faults.append(Fault(record.stage["file"], str(record.number), "is missing: the frame's stage"))
            continue
        try:
            faults += _frame(data, record, recorded)
            rendered += 1
        except UsdsdgError as error:
            notes.append(f"frame {record.number} cannot be rendered again: {error}")
        if progress is not None:
            progress("frames rendered again", done, len(chosen))
    if faults:
        notes += [
            f"{name} of the assets root has other content than when the dataset was made" for name in recorded.changed()
        ]
    return faults, notes, rendered


def _frame(data: Folder, record: FrameRecord, recorded: RecordedAssets) -> list[Fault]:
    with TemporaryFolder("redraw") as folder:
        stage = _stage(data, record, folder, recorded)
        time = Usd.TimeCode.Default() if record.stage["time"] is None else Usd.TimeCode(record.stage["time"])
        renderer = engines.renderer()
        renderer.glass_labels = record.stage["glass"]
        renderer.sync(time)
        faults = []
        for product in record.products:
            faults += _product(record, product, stage, time)
        return faults


def _stage(data: Folder, record: FrameRecord, folder: Path, recorded: RecordedAssets) -> Usd.Stage:
    """Open the stage of a record, with its edits in a stronger layer."""
    edits = folder / "edits.usda"
    edits.write_bytes(recorded.here(record.edits, "edits.usda") or b"#usda 1.0\n")
    _leave_out_prototypes(edits)
    top = Sdf.Layer.CreateNew(str(folder / "frame.usda"))
    below = folder / "stage.usda"
    content = gzip.decompress((data.path / record.stage["file"]).read_bytes())
    below.write_bytes(recorded.here(content, "stage.usda"))
    base = Sdf.Layer.FindOrOpen(str(below))
    top.subLayerPaths = [str(edits), base.identifier]
    for name in ("upAxis", "metersPerUnit", "timeCodesPerSecond", "startTimeCode", "endTimeCode"):
        if base.pseudoRoot.HasInfo(name):  # metadata of sublayers does not count
            top.pseudoRoot.SetInfo(name, base.pseudoRoot.GetInfo(name))
    top.Save()
    return stage_context.open_stage(folder / "frame.usda")


def _leave_out_prototypes(edits: Path) -> None:
    """Leave out edits of prims in prototypes of instances, as older records have them: with them USD would crash."""
    layer = Sdf.Layer.FindOrOpen(str(edits))
    roots = [prim for prim in layer.rootPrims if Usd.Prim.IsPathInPrototype(prim.path)]
    for prim in roots:
        del layer.rootPrims[prim.name]
    if roots:
        layer.Save()


def _product(record: FrameRecord, product: ProductRecord, stage: Usd.Stage, time: Usd.TimeCode) -> Faults:
    where = f"frame {record.number} of {product.name}"
    file, frame = f".usdsdg/frames: {where}", str(record.number)
    views = []
    for view in product.cameras:
        now = read_camera(stage, view.prim_path, (view.width, view.height), time=time)
        views.append(now)
        if differs(now.local_to_world, view.local_to_world, relative=1e-6) or not _same_lens(now, view):
            yield Fault(
                file, frame, f"the camera {view.prim_path} is elsewhere on the stage", text(now.local_to_world),
                text(view.local_to_world),
            )  # fmt: skip
    divided = bool(record.stage["subsets"])
    yield from _poses(file, frame, product, stage, time, divided=divided)
    if product.gprim_image is None:
        return
    entries = _entries(stage, time, divided=divided)
    yield from _labels(file, frame, product, stage, time, everything=entries.names)
    if len(views) == 1:
        yield from _images(file, frame, product, views[0], entries)


def _same_lens(a: CameraView, b: CameraView) -> bool:
    names = ("projection_type", "focal_length", "horizontal_aperture", "clipping_range", "lens_parameters")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


class _Entries(NamedTuple):
    """What pixels may show: gprims, and after them the subsets of faces that labels tell apart."""

    names: list[str]
    faces: dict[int, np.ndarray]  # of each gprim with subsets: the index in `names` of each of its faces


def _entries(stage: Usd.Stage, time: Usd.TimeCode, *, divided: bool) -> _Entries:
    """Return what pixels may show; divided: whether faces show their subset."""
    found = _Entries(list(engines.renderer().gprims), {})
    for gprim, name in enumerate(tuple(found.names) if divided else ()):
        path = prim_path(name)
        subsets, of_face = read_face_parts(stage.GetPrimAtPath(path), time)
        if subsets:
            index = np.append(len(found.names) + np.arange(len(subsets)), gprim)  # face -1 is the mesh's
            found.faces[gprim] = index[of_face].astype(np.int32)
            found.names.extend(f"{subset}{name[len(str(path)) :]}" for subset in subsets)
    return found


def _images(file: str, frame: str, product: ProductRecord, view: CameraView, entries: _Entries) -> Faults:
    """Every pixel shows the gprim, or subset of faces, that is recorded, at the recorded depth."""
    (found,) = engines.renderer().labels_of([view], AOVS, faces=entries.faces)
    assert product.gprim_image is not None
    names = np.array([*entries.names, "nothing"])
    recorded = np.array([*product.gprims, "nothing"])
    now, before = names[found["instance"]], recorded[product.gprim_image]
    wrong = now != before
    if wrong.sum() > max(_ODD * wrong.size, 1):
        row, column = np.argwhere(wrong)[0].tolist()
        yield Fault(
            file, frame, f"{int(wrong.sum())} pixels, first in column {column} of row {row}, show another gprim",
            str(now[row, column]), str(before[row, column]),
        )  # fmt: skip
    if product.depth is not None:
        depth = samples.grid(found["distance_to_camera"])
        same = np.isclose(depth, product.depth, rtol=_DEPTH, atol=0.0) | (np.isinf(depth) & np.isinf(product.depth))
        if (~same).sum() > max(_ODD * same.size, 1):
            at = tuple(np.argwhere(~same)[0])
            yield Fault(
                file, frame, f"depth differs in {int((~same).sum())} of {same.size} places", f"{depth[at]:.6g} m",
                f"{product.depth[at]:.6g} m",
            )  # fmt: skip


def _poses(
    file: str, frame: str, product: ProductRecord, stage: Usd.Stage, time: Usd.TimeCode, *, divided: bool
) -> Faults:
    """Every recorded prim is where the stage has it, and its box holds what it draws."""
    cache = UsdGeom.XformCache(time)
    for row, name in enumerate(product.prims):
        if "[" in name:
            continue  # a point instance has no prim
        prim = stage.GetPrimAtPath(name)
        if not prim:
            yield Fault(file, frame, f"{name} is not on the stage")
            continue
        pose = np.array(cache.GetLocalToWorldTransform(prim), np.float64).reshape(4, 4)
        if differs(product.local_to_world[row], pose, relative=2e-6, absolute=1e-6):
            yield Fault(file, frame, f"{name} is elsewhere on the stage", text(pose), text(product.local_to_world[row]))
        own = bounds_of_part(prim, time) if divided else bounds_of(prim, time)
        recorded, whole = product.bounds[row], bounds_below(prim, time, cache)
        is_other = own is not None and np.abs(recorded - own).max() > _OF_SIZE * (own[1] - own[0]).max()
        if whole is not None:
            margin = _OF_SIZE * (whole[1] - whole[0]).max()
            is_other |= bool((recorded[0] < whole[0] - margin).any() or (recorded[1] > whole[1] + margin).any())
        if is_other:
            expected = own if own is not None else whole
            yield Fault(file, frame, f"the box of {name} is another on the stage", text(expected), text(recorded))


def _labels(
    file: str, frame: str, product: ProductRecord, stage: Usd.Stage, time: Usd.TimeCode, *, everything: Sequence[str]
) -> Faults:
    """Every visible gprim belongs to its nearest labeled ancestor, with the labels of all above it, and of materials.

    everything: the gprims of the stage, since a prim has the labels of the materials of all its gprims, seen or not.
    """
    shown = _materials(stage, everything, time)
    for key, selection in product.selections.items():
        label_filter = parse_filter(key)
        owners = {path: _owner(stage.GetPrimAtPath(path), label_filter, time, shown.get(path)) for path in shown}
        for gprim, member in zip(product.gprims, selection.member_of_gprim.tolist()):
            # A point instance has no prim.
            prim = None if "[" in gprim else stage.GetPrimAtPath(gprim)
            if not prim:
                continue
            recorded = product.prims[selection.rows[member]] if member >= 0 else "nothing labeled"
            owner = _owner(prim, label_filter, time, shown.get(gprim))
            expected_labels = {}
            if owner is not None:
                labels = _chain(owner, time) + [of for path, (_, of) in shown.items() if owners[path] == owner]
                expected_labels = _output(labels, label_filter)
            # What passes by its own labels, and not with those that it inherits, is left out.
            expected = str(owner.GetPath()) if owner and expected_labels else "nothing labeled"
            if recorded != expected:
                yield Fault(file, frame, f"{gprim} belongs to", expected, recorded)
                continue
            if member < 0:
                continue
            if dict(selection.labels[member]) != expected_labels:
                yield Fault(
                    file, frame, f"the labels of {recorded}", str(expected_labels), str(dict(selection.labels[member]))
                )  # fmt: skip


_Labels = dict[str, list[str]]  # by type


def _materials(stage: Usd.Stage, gprims: Sequence[str], time: Usd.TimeCode) -> dict[str, tuple[Usd.Prim, _Labels]]:
    """Return for each of the gprims with a labeled material the prim that binds it, and the material's labels."""
    if not any(is_labeled(prim) for prim in stage.TraverseAll() if prim.IsA(UsdShade.Material)):
        return {}
    found = {}
    for path in gprims:
        prim = None if "[" in path else stage.GetPrimAtPath(path)
        if prim:
            material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            if material and (labels := _lower(material.GetPrim(), time)):
                found[path] = binding.GetPrim(), labels
    return found


def _owner(
    prim: Usd.Prim, label_filter: LabelFilter | None, time: Usd.TimeCode, shown: tuple[Usd.Prim, _Labels] | None
) -> Usd.Prim | None:
    """Return the nearest prim, at or above one, with labels that pass; those that it shows are of who binds them."""
    while prim and not prim.IsPseudoRoot():
        own = [_lower(prim, time)] + ([shown[1]] if shown is not None and shown[0] == prim else [])
        if any(own) and _output(own, label_filter):
            return prim
        prim = prim.GetParent()
    return None


def _chain(prim: Usd.Prim, time: Usd.TimeCode) -> list[_Labels]:
    """Return the labels of a prim and all above it, outermost first."""
    chain: list[_Labels] = []
    while prim and not prim.IsPseudoRoot():
        chain.insert(0, _lower(prim, time))
        prim = prim.GetParent()
    return chain


def _lower(prim: Usd.Prim, time: Usd.TimeCode) -> _Labels:
    return {kind: [each.lower() for each in labels] for kind, labels in get_labels(prim, time).items()}


def _output(chain: Sequence[_Labels], label_filter: LabelFilter | None) -> dict[str, str]:
    """Return the labels of all that pass, as annotators output them."""
    merged: _Labels = {}
    for own in chain:
        for kind, labels in own.items():
            merged.setdefault(kind, []).extend(each for each in labels if each not in merged.get(kind, []))
    kept = merged if label_filter is None else label_filter.select(merged)
    return {kind: ",".join(dict.fromkeys(labels)) for kind, labels in kept.items()}
