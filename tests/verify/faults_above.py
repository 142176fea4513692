"""Kinds of faults above the record: what is rendered or read of the stage is wrong, so that files and record agree."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import warp as wp
from pxr import Gf, Sdf, UsdGeom

from usdsdg.annotators.ownership import LabeledStage, Owner
from usdsdg.capture import capture, labels
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras import camera_reader
from usdsdg.stage.semantics.labels import add_labels
from usdsdg_render.sync.extract import SceneExtractor
from usdsdg_render.sync.invalidation import DirtySetBuilder

Patch = Callable[[object, str, Any], None]


class Above(NamedTuple):
    """A kind of fault; `edit` changes the stage before each frame, so that there is something to miss."""

    name: str
    install: Callable[[Patch], None]
    edit: Callable[[int], None] = lambda frame: None


KINDS: list[Above] = []


def above(name: str, edit: Callable[[int], None] = lambda frame: None) -> Callable[[Callable[[Patch], None]], None]:
    """Add the decorated function, which patches the product, to the table."""
    return lambda install: KINDS.append(Above(name, install, edit))


@contextmanager
def patched(kind: Above) -> Iterator[None]:
    """Install a fault, and take it out again."""
    with ExitStack() as stack:
        kind.install(lambda where, name, new: stack.enter_context(mock.patch.object(where, name, new)) and None)
        yield


def _relabel(frame: int) -> None:
    names = ("mug", "can", "box", "ball")
    add_labels(current_stage().GetPrimAtPath("/World/Thing_1"), {"class": [names[frame % 4]]}, mode="replace")


def _move_camera(frame: int) -> None:
    (op,) = UsdGeom.Xformable(current_stage().GetPrimAtPath("/World/Left")).GetOrderedXformOps()
    op.Set(op.Get() * Gf.Matrix4d().SetTranslate(Gf.Vec3d(0.3 * frame, 0, 0)))


def _changed(patch: Patch, change: Callable[[labels.ProductLabels], labels.ProductLabels]) -> None:
    """Change the labels of every product after they are rendered."""
    original = capture.render_labels
    patch(capture, "render_labels", lambda *a: {path: change(own) for path, own in original(*a).items()})


def _changed_prims(patch: Patch, **changes: Callable[[np.ndarray], np.ndarray]) -> None:
    def change(own: labels.ProductLabels) -> labels.ProductLabels:
        prims = own.labeled_prims
        values = {name: made(getattr(prims, name)) for name, made in changes.items()}
        return dataclasses.replace(own, labeled_prims=dataclasses.replace(prims, **values))

    _changed(patch, change)


@above("labels of another prim")
def _(patch: Patch) -> None:
    original, swapped = LabeledStage._labels, {"/World/Thing_1": "/World/Thing_2", "/World/Thing_2": "/World/Thing_1"}
    patch(LabeledStage, "_labels", lambda self, path: original(self, Sdf.Path(swapped.get(str(path), str(path)))))


@above("a part that belongs to the wrong prim")
def _(patch: Patch) -> None:
    original = LabeledStage._own_labels

    def own(self: LabeledStage, owner: Owner) -> Any:
        return {} if owner.path.name == "Lid" else original(self, owner)

    patch(LabeledStage, "_own_labels", own)


@above("labels of an earlier frame", _relabel)
def _(patch: Patch) -> None:
    original = LabeledStage._labels
    known: dict[Any, Any] = {}
    patch(LabeledStage, "_labels", lambda self, path: known.setdefault(path, original(self, path)))


@above("moved after the stage was read")
def _(patch: Patch) -> None:
    original = capture.Capture._stage_moment

    def moment(self: capture.Capture) -> Any:
        taken = original(self)
        translate = UsdGeom.Xformable(current_stage().GetPrimAtPath("/World/Thing_1")).GetOrderedXformOps()[0]
        translate.Set(translate.Get() + Gf.Vec3d(0.2, 0, 0.1))
        capture.engines.renderer().sync()
        return taken

    patch(capture.Capture, "_stage_moment", moment)


@above("images of the frame before")
def _(patch: Patch) -> None:
    original, count = SceneExtractor.update, iter(range(1_000_000))
    patch(SceneExtractor, "update", lambda self, time=None: original(self, time) if next(count) % 2 == 0 else None)


@above("hidden prims that are drawn")
def _(patch: Patch) -> None:
    original = DirtySetBuilder._add_part

    def without_visibility(self: DirtySetBuilder, part: str, paths: Any, names: Any) -> None:
        if part != "visibility":
            original(self, part, paths, names)

    patch(DirtySetBuilder, "_add_part", without_visibility)


@above("a camera of the first frame", _move_camera)
def _(patch: Patch) -> None:
    original = camera_reader.read_camera
    known: dict[str, Any] = {}

    def read(stage: Any, path: str, size: Any, **options: Any) -> Any:
        return known.setdefault(path, original(stage, path, size, **options))

    patch(camera_reader, "read_camera", read)


@above("images from right to left")
def _(patch: Patch) -> None:
    def flip(own: labels.ProductLabels) -> labels.ProductLabels:
        return dataclasses.replace(own, aovs={name: image[:, ::-1].copy() for name, image in own.aovs.items()})

    _changed(patch, flip)


@above("depth in centimeters")
def _(patch: Patch) -> None:
    def scale(own: labels.ProductLabels) -> labels.ProductLabels:
        aovs = {name: image * 100 if "distance" in name else image for name, image in own.aovs.items()}
        return dataclasses.replace(own, aovs=aovs)

    _changed(patch, scale)


@above("a gprim that is not drawn")
def _(patch: Patch) -> None:
    def drop(own: labels.ProductLabels) -> labels.ProductLabels:
        aovs = dict(own.aovs)
        image = aovs["instance"]
        found = image if isinstance(image, np.ndarray) else image.numpy()
        changed = np.where(found == 2, -1, found).astype(np.int32)
        aovs["instance"] = changed if image is found else wp.array(changed, device=image.device)
        return dataclasses.replace(own, aovs=aovs)

    _changed(patch, drop)


@above("names of gprims in another order")
def _(patch: Patch) -> None:
    def turn(own: labels.ProductLabels) -> labels.ProductLabels:
        gprims = own.table.gprims
        return dataclasses.replace(own, table=dataclasses.replace(own.table, gprims=(gprims[0], *gprims[:0:-1])))

    _changed(patch, turn)


@above("poses of the frame before")
def _(patch: Patch) -> None:
    last: list[np.ndarray] = []

    def stale(poses: np.ndarray) -> np.ndarray:
        last.append(poses)
        return last[-2] if len(last) > 1 and last[-2].shape == poses.shape else poses

    _changed_prims(patch, local_to_world=stale)


@above("boxes without scale")
def _(patch: Patch) -> None:
    _changed_prims(patch, bounds=lambda bounds: np.sign(bounds))
