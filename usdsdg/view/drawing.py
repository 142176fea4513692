"""Pictures of labels: AOVs and masks of a view to colors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.annotators.colors import colors_of_ids
from usdsdg.annotators.selection import Selection
from usdsdg.pictures.depth_colors import depth_colors
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.view.scene import Scene

# Part of a label's color over the shaded surface, and of an amodal mask over what hides it.
_OVER, _HIDDEN = 0.75, 0.4
# Brightness of surfaces seen at a right angle and along them, and of no surface.
_BRIGHT, _DARK, _EMPTY = 205, 70, 24
_OUTLINE = np.array((255, 170, 0), np.uint8)


@dataclass(frozen=True)
class Drawn:
    """A picture (H, W, 3) uint8, and what a page says beside it."""

    image: np.ndarray
    about: dict[str, Any] = field(default_factory=dict)


def draw(scene: Scene, view: CameraView, mode: str, outlined: frozenset[int] = frozenset()) -> Drawn:
    """Draw one of MODES.

    outlined: entries of the scene's table around which a line is drawn.
    """
    drawn = MODES[mode](scene, view)
    outline(scene, view, drawn.image, outlined)
    return drawn


def outline(scene: Scene, view: CameraView, image: np.ndarray, outlined: frozenset[int]) -> None:
    """Draw a line around the pixels of a view that show some entries of the scene's table, in place."""
    if outlined:
        member = np.zeros(len(scene.table.gprims) + 1, bool)
        member[list(outlined)] = True
        image[_edge(member[_labels(scene, view, "instance")["instance"]])] = _OUTLINE


def _edge(mask: np.ndarray) -> np.ndarray:
    """Return the pixels of a mask, and beside it, at which it ends."""
    edge = np.zeros_like(mask)
    across, down = mask[:, 1:] != mask[:, :-1], mask[1:] != mask[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _shaded(labels: dict[str, np.ndarray], view: CameraView) -> np.ndarray:
    """Return gray values (H, W) uint8 of surfaces lit from the camera."""
    back = view.local_to_world[2, :3].astype(np.float32)
    facing = np.abs(labels["normals"] @ back)
    gray = (_DARK + (_BRIGHT - _DARK) * facing).astype(np.uint8)
    gray[labels["instance"] < 0] = _EMPTY
    return gray


def _labels(scene: Scene, view: CameraView, *names: str) -> dict[str, np.ndarray]:
    return scene.read().labels_of([view], names, faces=scene.table.faces)[0]


def _of_members(scene: Scene, view: CameraView, colors: Callable[[Selection], np.ndarray]) -> tuple[np.ndarray, Any]:
    """Return the picture of the colors (K, 3) of the labeled prims, and how many pixels show each (K,)."""
    labels = _labels(scene, view, "instance", "normals")
    image, selection = np.repeat(_shaded(labels, view)[..., None], 3, axis=2), scene.labeled.select(None)
    if not len(selection):
        return image, np.zeros(0, np.int64)
    members = np.append(selection.member_of_gprim, -1)[labels["instance"]]
    shown = members >= 0
    mixed = image[shown] * np.float32(1 - _OVER) + colors(selection)[members[shown]] * np.float32(_OVER)
    image[shown] = mixed.astype(np.uint8)
    return image, np.bincount(members[shown], minlength=len(selection))


def _classes(scene: Scene, view: CameraView) -> Drawn:
    image, pixels = _of_members(scene, view, _class_colors)
    selection = scene.labeled.select(None)
    colors, rows = _class_colors(selection), np.flatnonzero(pixels)
    shown = {", ".join(selection.labels[row].values()): colors[row].tolist() for row in rows}
    return Drawn(image, {"classes": sorted(shown.items())})


def _class_colors(selection: Selection) -> np.ndarray:
    colors = colors_of_ids(selection.class_ids)[:, :3]
    for row, identifier in enumerate(selection.class_ids.tolist()):
        if identifier in selection.class_colors:
            colors[row] = selection.class_colors[identifier][:3]
    return colors


def _instances(scene: Scene, view: CameraView) -> Drawn:
    image, pixels = _of_members(scene, view, _instance_colors)
    return Drawn(image, {"objects": int((pixels > 0).sum())})


def _instance_colors(selection: Selection) -> np.ndarray:
    return colors_of_ids(selection.ids)[:, :3]


def _amodal(scene: Scene, view: CameraView) -> Drawn:
    """Draw all of each labeled prim, also what is hidden, with a line around it."""
    labeled, selection = scene.labeled, scene.labeled.select(None)
    (labels,), (masks,) = scene.read().labels_and_masks(
        [view], ["instance", "normals"], labeled.groups, faces=scene.table.faces
    )
    image = np.repeat(_shaded(labels, view)[..., None], 3, axis=2)
    colors, coverage = _instance_colors(selection), masks.coverage[selection.rows]
    # The largest first, so that small ones inside of them are seen.
    for place in np.argsort(-coverage[:, 0], kind="stable"):
        pixels, left, top, right, bottom = coverage[place].tolist()
        if not pixels:
            break
        mask = masks.crop(int(selection.rows[place]))
        part = image[top : bottom + 1, left : right + 1]
        part[mask] = (part[mask] * np.float32(1 - _HIDDEN) + colors[place] * np.float32(_HIDDEN)).astype(np.uint8)
        part[mask & _edge(np.pad(mask, 1))[1:-1, 1:-1]] = colors[place]
    hidden = sum(1 for row in selection.rows if masks.coverage[row, 0] > masks.visible[row])
    return Drawn(image, {"objects": int((coverage[:, 0] > 0).sum()), "hidden": hidden})


def _depth(scene: Scene, view: CameraView) -> Drawn:
    colored, ends = depth_colors(_labels(scene, view, "distance_to_camera")["distance_to_camera"])
    return Drawn(colored, {"depth": ends})


def _normals(scene: Scene, view: CameraView) -> Drawn:
    labels = _labels(scene, view, "instance", "normals")
    image = (127.5 * (labels["normals"] + np.float32(1.0))).astype(np.uint8)
    image[labels["instance"] < 0] = _EMPTY
    return Drawn(image)


# By the name that a page asks for.
MODES: dict[str, Callable[[Scene, CameraView], Drawn]] = {
    "classes": _classes,
    "instances": _instances,
    "amodal": _amodal,
    "depth": _depth,
    "normals": _normals,
}
PATHS = "paths"  # drawn by `usdsdg.view.paths`
