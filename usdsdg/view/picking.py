"""What a page says of a thing that was clicked: its prim, labels, pose, size, material and body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd, UsdPhysics, UsdShade

from usdsdg.annotators.point_instances import prim_path
from usdsdg.session.body_velocities import velocities
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.geometry.drawn_box import DrawnBoxes
from usdsdg.stage.poses.rotations import decompose
from usdsdg.stage.poses.transforms import as_array, local_to_world
from usdsdg.view.scene import Scene

_DECIMALS = 6  # micrometers


@dataclass(frozen=True)
class Picked:
    """A thing on the stage.

    Attributes:
        gprim: path of what was hit, with its number in a point instancer.
        owner: path of the labeled prim that it belongs to; the gprim itself without labels.
    """

    gprim: str
    owner: str

    def entries(self, scene: Scene) -> frozenset[int]:
        """Return the entries of the scene's table that belong to it now."""
        labeled = scene.labeled
        if self.owner in labeled.prim_paths:
            return frozenset(labeled.groups[labeled.prim_paths.index(self.owner)])
        return frozenset(index for index, path in enumerate(scene.table.gprims) if path == self.gprim)

    def facts(self, scene: Scene) -> dict[str, Any]:
        """Return what is known of it now, for the page. Lengths are in meters, angles in degrees."""
        labeled, unit = scene.labeled, scene.meters_per_unit
        row = labeled.prim_paths.index(self.owner) if self.owner in labeled.prim_paths else None
        found: dict[str, Any] = {"path": self.owner}
        if self.gprim != self.owner:
            found["gprim"] = self.gprim
        prim = scene.stage.GetPrimAtPath(prim_path(self.gprim))
        if not prim:
            return found | {"gone": True}
        time = scene.read().time
        found["type"] = str(prim.GetTypeName())
        if row is not None:
            found["labels"] = {kind: ", ".join(values) for kind, values in labeled.labels[row].items()}
            to_world, (low, high) = labeled.local_to_world[row], labeled.bounds[row]
            found["size"] = _numbers((high - low) * np.linalg.norm(to_world[:3, :3], axis=1) * unit)
        else:
            to_world = as_array(local_to_world(prim, time))
            box = DrawnBoxes(time).own(prim)
            span = None if box is None else (box[1] - box[0]) * np.linalg.norm(to_world[:3, :3], axis=1)
            found["size"] = _numbers(span * unit) if span is not None and np.isfinite(span).all() else None
        pose = decompose(to_world)
        found["position"] = _numbers(pose.translate * unit)
        x, y, z, w = pose.rotation
        found["rotation"] = _numbers(np.array([w, x, y, z]))
        found["scale"] = _numbers(pose.scale)
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if material:
            found["material"] = str(material.GetPath())
        return found | _body(prim, unit)

    def middle(self, scene: Scene) -> tuple[np.ndarray, float] | None:
        """Return the center (3,) and the diagonal of its bounds [stage units]; None where it has none."""
        paths = {prim_path(scene.table.gprims[entry]) for entry in self.entries(scene)}
        drawn = DrawnBoxes(scene.read().time)
        boxes = [drawn.in_world(prim) for prim in map(scene.stage.GetPrimAtPath, paths) if prim]
        corners = np.array([box for box in boxes if box is not None]).reshape(-1, 2, 3)
        if not len(corners) or not np.isfinite(corners).all():
            return None
        low, high = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
        return (low + high) / 2, float(np.linalg.norm(high - low))


def pick(scene: Scene, view: CameraView, place: tuple[float, float]) -> tuple[Picked, dict[str, Any]] | None:
    """Return what is at a place of a view, as parts of its width and height, and where it was hit; None: nothing."""
    hit = scene.first_hit(view, (place[0] * view.width, place[1] * view.height))
    if hit is None:
        return None
    distance, entry, point = hit
    labeled, unit = scene.labeled, scene.meters_per_unit
    gprim = scene.table.gprims[entry]
    row = int(labeled.row_of_gprim[entry]) if entry < len(labeled.row_of_gprim) else -1
    owner = labeled.prim_paths[row] if row >= 0 else gprim
    return Picked(gprim, owner), {"distance": _number(distance * unit), "point": _numbers(point * unit)}


def _body(prim: Usd.Prim, unit: float) -> dict[str, Any]:
    """Return the rigid body that a prim belongs to, with its velocities."""
    each = prim
    while each and not each.HasAPI(UsdPhysics.RigidBodyAPI):
        each = each.GetParent()
    if not each:
        return {}
    (velocity,), (angular,) = velocities([each])
    return {
        "body": str(each.GetPath()),
        "velocity": _numbers(velocity * unit),
        "angular velocity": _numbers(np.degrees(angular)),
    }


def _numbers(values: np.ndarray) -> list[float]:
    return [_number(value) for value in values.tolist()]


def _number(value: float) -> float:
    return round(value, _DECIMALS) + 0.0 if np.isfinite(value) else 0.0  # + 0.0 turns -0 into 0
