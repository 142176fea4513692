"""Write positions and velocities of joints to those that have PhysicsJointStateAPI."""

from collections.abc import Iterable

import numpy as np
from pxr import Sdf, Usd

from usdsdg_physics.scene.records import Joint
from usdsdg_physics.writeback.freeze import freeze
from usdsdg_physics.writeback.restore import Backup, attribute_spec


class JointStateWriter:
    """Writes into one edit target, as `StageWriter` does for bodies."""

    def __init__(self, stage: Usd.Stage, joints: Iterable[Joint], backup: Backup, *, meters_per_unit: float) -> None:
        target = stage.GetEditTarget()
        # Path of the joint and name of the axis, in the order of `write`.
        self.axes: list[tuple[str, str]] = []
        self._specs: list[tuple[Sdf.AttributeSpec, Sdf.AttributeSpec]] = []
        units = []
        for joint in joints:
            for axis in joint.axes:
                if not axis.has_state:
                    continue
                specs = []
                for name in ("position", "velocity"):
                    attribute = stage.GetPrimAtPath(joint.path).GetAttribute(f"state:{axis.instance}:physics:{name}")
                    freeze(attribute, target, backup)
                    backup.keep(target.GetLayer(), target.MapToSpecPath(attribute.GetPath()))
                    specs.append(attribute_spec(target, attribute))
                self.axes.append((joint.path, axis.name))
                self._specs.append((specs[0], specs[1]))
                units.append(np.pi / 180.0 if axis.angular else meters_per_unit)
        self._units = np.array(units)
        self._written = np.full((len(units), 2), np.nan, np.float32)

    def write(self, positions: np.ndarray, velocities: np.ndarray) -> None:
        """Author positions and velocities (n,) of `axes` [m, rad] where they changed."""
        values = np.stack([positions / self._units, velocities / self._units], axis=1).astype(np.float32)
        with Sdf.ChangeBlock():
            for row, column in zip(*np.nonzero(values != self._written)):
                self._specs[row][column].default = float(values[row, column])
        self._written = values
