"""`GridCloner`: copies of a prim in a grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.cloner.cloner import Cloner
from usdsdg.compat.wrappers import rotations
from usdsdg.compat.wrappers.arrays import as_numpy
from usdsdg.errors import counted
from usdsdg.stage.poses.transforms import up_axis

if TYPE_CHECKING:
    from usdsdg.compat.wrappers.arrays import Values


class GridCloner(Cloner):
    """Makes copies in rows around the origin, in the ground plane."""

    def __init__(self, spacing: float, num_per_row: int = -1, stage: Usd.Stage | None = None) -> None:
        """Set the distance of copies [stage units] and the number per row, by default the root of their number."""
        super().__init__(stage)
        self._spacing, self._num_per_row = float(spacing), num_per_row

    def get_clone_transforms(
        self, num_clones: int, position_offsets: Values | None = None, orientation_offsets: Values | None = None
    ) -> tuple[list[list[float]], list[list[float]]]:
        """Return positions (3,) and orientations (4,), w, x, y, z, of the copies; the first are at the largest x.

        Raises:
            ValueError: there are not as many offsets as copies, or no copies in a row.
        """
        if num_clones < 0 or self._num_per_row == 0 or self._num_per_row < -1:
            copies = counted(num_clones, "copy", "copies")
            raise ValueError(f"a grid of {copies} with {self._num_per_row} in a row cannot be made")
        for values in (position_offsets, orientation_offsets):
            if values is not None and len(as_numpy(values)) != num_clones:
                given = counted(len(as_numpy(values)), "offset is", "offsets are")
                raise ValueError(f"{given} given for {counted(num_clones, 'copy', 'copies')}")
        if num_clones == 0:
            return [], []
        places = self._grid(num_clones)
        turns = np.tile((1.0, 0.0, 0.0, 0.0), (num_clones, 1))
        if position_offsets is not None:
            places = places + as_numpy(position_offsets)
        if orientation_offsets is not None:
            turns = rotations.multiplied(as_numpy(orientation_offsets), turns)
        return places.tolist(), turns.tolist()

    def clone(  # pyright: ignore[reportIncompatibleMethodOverride]
        self,
        source_prim_path: str,
        prim_paths: Sequence[str],
        position_offsets: Values | None = None,
        orientation_offsets: Values | None = None,
        replicate_physics: bool = False,
        base_env_path: str | None = None,
        root_path: str | None = None,
        copy_from_source: bool = False,
        enable_env_ids: bool = False,
        clone_in_fabric: bool = False,
    ) -> list[list[float]]:
        """Copy a prim to several paths in a grid, see `Cloner.clone`; return the positions."""
        places, turns = self.get_clone_transforms(len(prim_paths), position_offsets, orientation_offsets)
        super().clone(
            source_prim_path, prim_paths, places, turns, replicate_physics,
            copy_from_source=copy_from_source, enable_env_ids=enable_env_ids,
        )  # fmt: skip
        return places

    def _grid(self, count: int) -> np.ndarray:
        per_row = int(math.sqrt(count)) if self._num_per_row == -1 else self._num_per_row
        rows = math.ceil(count / per_row)
        columns = math.ceil(count / rows)
        row, column = np.divmod(np.arange(count), columns)
        x = (0.5 * (rows - 1) - row) * self._spacing
        y = (column - 0.5 * (columns - 1)) * self._spacing
        zero = np.zeros(count)
        return np.stack([x, y, zero] if up_axis(self._stage) == "Z" else [x, zero, y], -1)
