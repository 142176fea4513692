"""Rigs: several calibrated cameras that move as one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.calibration.calibration import Calibration, author_calibration
from usdsdg.stage.paths import next_free_path, valid_name
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

# From OpenCV's axes (x right, y down, z ahead) to those of a camera prim (x right, y up, -z ahead).
_TO_PRIM = np.diag((1.0, -1.0, -1.0, 1.0))
# From OpenCV's axes to those of an object that looks ahead as Replicator's cameras do: along -X with +Z up in a Z-up
# stage, along -Z with +Y up in a Y-up one.
_TO_OBJECT = {
    "Z": np.array([[0, 0, -1, 0], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]], np.float64),
    "Y": _TO_PRIM,
}


@dataclass(frozen=True)
class Mount:
    """A camera of a rig. `pose` (4, 4), column vectors, takes points from the camera to the rig [meters], both with x
    right, y down and z ahead."""

    name: str
    calibration: Calibration
    pose: np.ndarray


@dataclass(frozen=True)
class Rig:
    """Cameras that move as one; at least one."""

    mounts: tuple[Mount, ...]


def author_mount(stage: Usd.Stage, parent: str, mount: Mount) -> Usd.Prim:
    """Create a camera of a rig below the prim that is the rig, which looks ahead as Replicator's cameras do."""
    prim = UsdGeom.Camera.Define(stage, next_free_path(stage, f"{parent}/{valid_name(mount.name)}")).GetPrim()
    pose = _TO_OBJECT[up_axis(stage)] @ mount.pose @ _TO_PRIM
    pose[:3, 3] /= meters_per_unit(stage)
    UsdGeom.Xformable(prim).AddTransformOp().Set(Gf.Matrix4d(pose.T.tolist()))
    author_calibration(prim, mount.calibration)
    return prim
